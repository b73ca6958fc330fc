"""What renderer, headset and session say of a frame."""
