"""The literature of the methods section; the entries stand in ``analysis/references.toml``."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING

from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from collections.abc import Iterable

FILE = "references.toml"


def entries(cited: Iterable[str]) -> list[str]:
    """Return the entries of these keys, in the order of the list.

    Raises
    ------
    KeyError
        If there is no such entry.
    """
    text = (data_folder("analysis") / FILE).read_text(encoding="utf-8")
    known: dict[str, str] = tomllib.loads(text)
    wanted = set(cited)
    if unknown := wanted - known.keys():
        raise KeyError(f"no reference {sorted(unknown)[0]}")
    return [entry for key, entry in known.items() if key in wanted]
