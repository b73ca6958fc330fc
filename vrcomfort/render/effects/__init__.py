"""Effects on the image of one eye, one module each."""
