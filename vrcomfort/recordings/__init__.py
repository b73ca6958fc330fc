"""Recordings of any length: packed into Parquet, and summed by exposure.

`vrcomfort.records.recording` reads them.
"""

from vrcomfort.recordings.exposures import ExposureFrames, frame_measures
from vrcomfort.recordings.pack import Packed, pack_study, recordings_in
from vrcomfort.recordings.ratings import (
    GAP,
    KEYS_OF_RATINGS,
    RatingSeries,
    joined,
    read_ratings,
    series_of,
    usual_interval_s,
)

__all__ = [
    "GAP",
    "KEYS_OF_RATINGS",
    "ExposureFrames",
    "Packed",
    "RatingSeries",
    "frame_measures",
    "joined",
    "pack_study",
    "read_ratings",
    "recordings_in",
    "series_of",
    "usual_interval_s",
]
