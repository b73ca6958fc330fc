"""What a study leaves on disk: row types (their fields are the CSV columns), recorder, reader."""
