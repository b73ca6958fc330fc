"""Head logs of other programs: read in any layout, understood through a mapping, as traces."""

from vrcomfort.importing.head_logs.convert import import_log
from vrcomfort.importing.head_logs.mapping import (
    UNITY_EULER,
    LogMapping,
    load_log_mapping,
    parse_log_mapping,
)
from vrcomfort.importing.head_logs.suggest import LogSuggestion, described, suggest_log_mapping

__all__ = [
    "UNITY_EULER",
    "LogMapping",
    "LogSuggestion",
    "described",
    "import_log",
    "load_log_mapping",
    "parse_log_mapping",
    "suggest_log_mapping",
]
