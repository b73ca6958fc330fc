"""A study as a BIDS dataset: motion, gaze, events, questionnaires."""

from vrcomfort.exchange.bids.export import export_bids

__all__ = ["export_bids"]
