"""Protocols: what a study shows, asks and when; read from TOML and validated."""
