"""Finds one focus distance for both eyes: by rays, by a zone, by gaze, by script."""
