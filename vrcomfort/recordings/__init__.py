"""Recordings of any length: frames read out of core, packed into Parquet, summed by exposure.

The CSV stays the record. A Parquet file beside it holds the same rows and is read in its place as
long as it is of that CSV.
"""

from vrcomfort.recordings.exposures import ExposureFrames, frame_measures
from vrcomfort.recordings.memory import Memory
from vrcomfort.recordings.pack import Packed, pack_study
from vrcomfort.recordings.source import Source, find_source, read_columns
from vrcomfort.recordings.words import Words, read_words

__all__ = [
    "ExposureFrames",
    "Memory",
    "Packed",
    "Source",
    "Words",
    "find_source",
    "frame_measures",
    "pack_study",
    "read_columns",
    "read_words",
]
