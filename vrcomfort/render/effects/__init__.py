"""What a condition does to the image: one effect each."""
