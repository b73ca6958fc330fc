"""The literature of the methods section; its entries stand in `FILE`, or in an analysis."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING

from vrcomfort.report.analyses import references
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from collections.abc import Iterable

FILE = "references.toml"


def is_known(key: str) -> bool:
    """Return whether there is such an entry."""
    return key in _known()


def entries(cited: Iterable[str]) -> list[str]:
    """Return the entries of these keys, in the order of their texts.

    Raises
    ------
    KeyError
        If there is no such entry.
    """
    known = _known()
    wanted = set(cited)
    if unknown := wanted - known.keys():
        raise KeyError(f"no reference {sorted(unknown)[0]}")
    return sorted((known[key] for key in wanted), key=str.casefold)


def _known() -> dict[str, str]:
    text = (data_folder("analysis") / "report" / FILE).read_text(encoding="utf-8")
    known: dict[str, str] = tomllib.loads(text)
    return known | references()
