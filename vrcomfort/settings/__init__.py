"""Settings in TOML files: read strictly, and every fault said with its place."""

from vrcomfort.settings.include import to_toml, toml_key, toml_value
from vrcomfort.settings.locate import Path as KeyPath
from vrcomfort.settings.reading import (
    Name,
    Problem,
    Settings,
    Word,
    did_you_mean,
    first_problem,
    in_words,
    parse_settings,
    problems_of,
    read_toml,
    repeated,
    reserved,
    union_tag,
)

__all__ = [
    "KeyPath",
    "Name",
    "Problem",
    "Settings",
    "Word",
    "did_you_mean",
    "first_problem",
    "in_words",
    "parse_settings",
    "problems_of",
    "read_toml",
    "repeated",
    "reserved",
    "to_toml",
    "toml_key",
    "toml_value",
    "union_tag",
]
