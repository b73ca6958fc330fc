"""Sorting names as people do: P2 before P10."""

from vrcomfort.records.names import natural

__all__ = ["natural"]
