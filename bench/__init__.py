"""Benchmarks of cost and error; `python -m bench` writes the tables."""
