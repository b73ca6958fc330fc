"""Recordings of any length: packed into Parquet, and summed by exposure.

`vrcomfort.records.recording` reads them.
"""

from vrcomfort.recordings.exposures import ExposureFrames, frame_measures
from vrcomfort.recordings.pack import Packed, pack_study

__all__ = ["ExposureFrames", "Packed", "frame_measures", "pack_study"]
