"""The order that people really met, whatever was planned: positions, carry-over, sequences."""

from __future__ import annotations

from collections import Counter, defaultdict
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from vrcomfort.records.names import natural

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

Row = dict[str, Any]


def counterbalancing(
    table: pd.DataFrame, conditions: Iterable[str], analysed: Iterable[str]
) -> dict[str, Any] | None:
    """Count positions and carry-over over the scored exposures of those analysed.

    Returns
    -------
    dict or None
        `positions`: condition → count at each place of a session (of the study, if a session has
        one exposure); `carry_over`: before, after and count within those; `orders`: the orders of
        conditions and how many people met each; `balanced`: of positions. None where the data do
        not say the order, or have no conditions.
    """
    part = table[table["participant"].isin(list(analysed)) & (table["position"] > 0)]
    names = [name for name in conditions if (part["condition"] == name).any()]
    if not names:
        return None
    runs = _runs(part)
    longest = max(len(run) for _, run in runs)
    places = Counter((name, place) for _, run in runs for place, name in enumerate(run))
    positions = {name: [places[name, place] for place in range(longest)] for name in names}
    carried = Counter(pair for _, run in runs for pair in pairwise(run))
    orders = _orders(runs)
    return {
        "positions": positions,
        "carry_over": [
            {"before": a, "after": b, "n": carried[a, b]} for a in names for b in names
        ] if carried else [],
        "orders": orders,
        "balanced": all(len(set(column)) == 1 for column in zip(*positions.values(), strict=True)),
    }  # fmt: skip


def _runs(part: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Return (participant, conditions in order) of each session, or of each person."""
    alone = not part.duplicated(["participant", "session"]).any()
    found: dict[tuple[str, ...], list[tuple[int, str]]] = defaultdict(list)
    columns = ["participant", "session", "position", "condition"]
    for who, session, position, condition in part[columns].itertuples(index=False):
        found[(who,) if alone else (who, session)].append((position, condition))
    ordered = sorted(found, key=lambda key: tuple(map(natural, key)))
    return [(key[0], [name for _, name in sorted(found[key])]) for key in ordered]


def _orders(runs: list[tuple[str, list[str]]]) -> list[Row]:
    met: dict[str, list[list[str]]] = defaultdict(list)
    for who, run in runs:
        met[who].append(run)
    counts = Counter(tuple(map(tuple, sessions)) for sessions in met.values())
    listed = sorted(counts.items(), key=lambda each: (-each[1], each[0]))
    return [{"sessions": [list(run) for run in order], "n": n} for order, n in listed]
