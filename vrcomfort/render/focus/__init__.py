"""Finds the focus distance: by nine rays, by a zone, by gaze; and applies the refocus law."""
