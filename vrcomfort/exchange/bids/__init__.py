"""A study as a BIDS dataset: motion, gaze, events, questionnaires."""

from vrcomfort.exchange.bids.dataset import export_bids

__all__ = ["export_bids"]
