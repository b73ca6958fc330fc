"""Ranges of possible values: no interval on a page ends where no value can be."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

if TYPE_CHECKING:
    from collections.abc import Mapping

Found = TypeVar("Found")


class Possible(NamedTuple):
    """The lowest and the highest value that there can be; None: no limit."""

    low: float | None = None
    high: float | None = None

    @property
    def difference(self) -> Possible:
        """Return the range of the difference of two such values, and of two such means."""
        if self.low is None or self.high is None:
            return Possible()
        return Possible(self.low - self.high, self.high - self.low)

    def held(self, value: float | None) -> float | None:
        """Return a value, or the limit that it is beyond."""
        if value is None:
            return None
        above = value if self.low is None else max(value, self.low)
        return above if self.high is None else min(above, self.high)


def limited(found: Found, possible: Possible, ends: tuple[str, str] = ("low", "high")) -> Found:
    """Limit an estimate's interval to the possible range; None stays None.

    One that lies beyond it altogether (of a model that misses the scale) has no interval.
    """
    if found is None or possible == (None, None):
        return found
    low, high = (getattr(found, name) for name in ends)
    held = dict(zip(ends, (possible.held(low), possible.held(high)), strict=True))
    if low != high and held[ends[0]] == held[ends[1]]:
        held = dict.fromkeys(ends)
    of: Any = found
    changed: Found = replace(of, **held)
    return changed


def all_limited(found: Mapping[str, Found], possible: Possible) -> dict[str, Found]:
    """Return each estimate of a table of them, as `limited`."""
    return {name: limited(each, possible) for name, each in found.items()}
