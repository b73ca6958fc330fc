"""In how many unseen scenes each step of depth of field keeps to its bounds.

``python -m bench.unseen_summary out/bench/unseen.json [MORE.json …]`` sums up what
``python -m bench --only unseen`` wrote. The best other method is another one for each measure and
scene; ``scatter``, the ideal of what one image allows, is none of them.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.table import Result, write

Row = dict[str, Any]
MORE_SEAMS = 75
"""Than the reference has."""
EDGES_PART, RIVALRY_PART = 0.6, 1.5
"""Of the best other method's error, and of the ideal scatter's."""


def summary(rows: Sequence[Row]) -> Result:
    """Return a row for each of our steps."""
    seeds = list(dict.fromkeys(row["seed"] for row in rows))
    scenes = [{row["method"]: row for row in rows if row["seed"] == seed} for seed in seeds]
    ours = [name for name in scenes[0] if name.startswith("ours")]
    notes = [f"Seeds {', '.join(map(str, seeds))}."]
    return Result("Unseen scenes, summed up", [_row(name, scenes) for name in ours], notes)


def _row(name: str, scenes: Sequence[dict[str, Row]]) -> Row:
    count = len(scenes)
    with_edges = [scene for scene in scenes if _best_other(scene, "edges") > 0]
    edges = np.array([scene[name]["edges"] / _best_other(scene, "edges") for scene in with_edges])
    rms = [scene[name]["rms"] / _best_other(scene, "rms") for scene in scenes]
    seams = [scene[name]["seams"] <= _reference(scene)["seams"] + MORE_SEAMS for scene in scenes]
    cuts = [scene[name]["cuts"] for scene in scenes]
    return {
        "method": name,
        "edges / best other, median": float(np.median(edges)),
        "worst": float(edges.max()),
        f"at most {EDGES_PART}": f"{(edges <= EDGES_PART).sum()} of {len(edges)}",
        "seams": f"{sum(seams)} of {count}",
        "no cut": f"{cuts.count(0)} of {count}",
        "most cuts": max(cuts),
        **(_of_moved(name, scenes) if "flicker" in scenes[0][name] else {}),
        "RMS / best other, median": float(np.median(rms)),
    }


def _of_moved(name: str, scenes: Sequence[dict[str, Row]]) -> Row:
    """Return what ``--still`` leaves out."""
    count = len(scenes)
    flicker = [scene[name]["flicker"] <= _best_other(scene, "flicker") for scene in scenes]
    ideal = [scene["scatter"]["rivalry"] for scene in scenes]
    rivalry = np.array([scene[name]["rivalry"] for scene in scenes]) / ideal
    return {
        "flicker ≤ best other": f"{sum(flicker)} of {count}",
        f"rivalry ≤ {RIVALRY_PART} scatter": f"{(rivalry <= RIVALRY_PART).sum()} of {count}",
        "rivalry / scatter, median": float(np.median(rivalry)),
    }


def _best_other(scene: dict[str, Row], measure: str) -> float:
    rest = ("ours", "reference", "scatter", "no blur")
    return float(min(row[measure] for name, row in scene.items() if not name.startswith(rest)))


def _reference(scene: dict[str, Row]) -> Row:
    return next(row for name, row in scene.items() if name.startswith("reference"))


if __name__ == "__main__":
    files = [Path(each) for each in sys.argv[1:]]
    found = [row for file in files for row in json.loads(file.read_text("utf-8"))["rows"]]
    write(files[0].parent, "unseen_summary", summary(found))
