"""Head and gaze traces: columns, reading, importing, interpolation, synthesis."""
