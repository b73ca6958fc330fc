"""How long the gaze was on each node of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from vrcomfort.report.gaze_and_head.motion import Motion

Row = dict[str, Any]
NOTHING = ""
"""The name of what is no node: the sky."""
SHOWN = 10
"""Nodes that stand on the page; the others are summed."""


def node_shares(motion: Motion) -> dict[str, float]:
    """Return node → share of the time in which the gaze was known and the scene drawn.

    Empty where the nodes are not known: they were not recorded, or the gaze met none at all.
    """
    if motion.nodes is None:
        return {}
    known = motion.valid & motion.drawn
    places, seconds = motion.nodes.codes[known], motion.seconds[known]
    if not (places >= 0).any():
        return {}
    # Blank cells are −1: the first of the sums is that of nothing.
    sums = np.bincount(places + 1, weights=seconds, minlength=1 + len(motion.nodes.names))
    names = (NOTHING, *motion.nodes.names)
    return {
        name: share
        for name, share in zip(names, (sums / sums.sum()).tolist(), strict=True)
        if share
    }


def node_rows(names: Sequence[str], people: Mapping[str, NDArray[np.float64]]) -> list[Row]:
    """Return a row for each situation and node: the mean share over people, with its error.

    Parameters
    ----------
    names
        Nodes, and `NOTHING`.
    people
        Situation → (people, names) share of each person.

    Returns
    -------
    list of dict
        In the order of the mean of all situations, the longest looked at first; `NOTHING` is last.
    """
    known = {name: shares for name, shares in people.items() if len(shares)}
    if not known:
        return []
    over_all = np.mean([shares.mean(axis=0) for shares in known.values()], axis=0)
    order = sorted(
        range(len(names)), key=lambda at: (names[at] == NOTHING, -over_all[at], names[at])
    )
    return [
        _row(situation, "node" if names[at] else "nothing", names[at], shares[:, at])
        for situation, shares in known.items()
        for at in order
    ]


def shown_nodes(
    rows: Sequence[Row], names: Sequence[str], people: Mapping[str, NDArray[np.float64]]
) -> list[Row]:
    """Return the rows of the longest looked at; the others are one row, summed for each person."""
    nodes = list(dict.fromkeys(row["node"] for row in rows if row["kind"] == "node"))
    few, rest = nodes[:SHOWN], nodes[SHOWN:]
    at = [place for place, name in enumerate(names) if name in set(rest)]
    found = [row for row in rows if row["node"] in few or row["kind"] == "nothing"]
    if rest:
        label = f"{len(rest)} others"
        found += [
            _row(situation, "others", label, shares[:, at].sum(axis=1))
            for situation, shares in people.items()
            if len(shares)
        ]
    return found


def _row(
    situation: str,
    kind: Literal["node", "others", "nothing"],
    name: str,
    shares: NDArray[np.float64],
) -> Row:
    error = float(shares.std(ddof=1) / np.sqrt(len(shares))) if len(shares) > 1 else None
    return {
        "situation": situation, "kind": kind, "node": name, "share": float(shares.mean()),
        "standard_error": error, "people": len(shares),
    }  # fmt: skip
