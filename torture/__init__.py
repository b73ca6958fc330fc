"""Tries to lose what a session records, and to break what reads files: `python -m torture`."""
