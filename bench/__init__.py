"""What each effect costs and how wrong it is; `python -m bench` writes the tables."""
