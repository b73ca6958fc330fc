"""Marks of settings: metadata in `Annotated`, and its derivations.

A setting says itself when it has an effect and whether participants can adjust it while it is
shown; the check of protocols, adjustments, the reference of keys and the tests read the marks.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from pydantic import BaseModel

from vrcomfort.settings.schema import tables_of


class OnlyWith:
    """Has an effect only beside certain values of other settings of the same table.

    Parameters
    ----------
    needs
        Other setting → its values, of which one is needed.
    """

    def __init__(self, **needs: Collection[Any]) -> None:
        self.needs = needs


class Live:
    """Adjustable between two frames; other settings are built in, and cannot change."""


LIVE = Live()


def needs_of(table: type[BaseModel]) -> dict[str, dict[str, Collection[Any]]]:
    """Return setting → required values of other settings, where there are any."""
    return {
        name: mark.needs
        for name, field in table.model_fields.items()
        for mark in field.metadata
        if isinstance(mark, OnlyWith)
    }


def live_settings(table: type[BaseModel], path: str = "") -> Iterator[str]:
    """Yield the dotted names of the settings of a table, and of tables in it, that are `LIVE`."""
    for name, field in table.model_fields.items():
        if any(isinstance(mark, Live) for mark in field.metadata):
            yield path + name
        for inner in tables_of(field.annotation):
            yield from live_settings(inner, f"{path}{name}.")
