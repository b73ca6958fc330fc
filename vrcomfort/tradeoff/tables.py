"""The tables as Markdown, and numbers as text."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from vrcomfort.tradeoff.measure import SCATTER
from vrcomfort.tradeoff.timing import LONGEST_S, P95_ROUNDS, P99_ROUNDS, SLOW_S
from vrcomfort.tradeoff.walk import TURN_DEG_PER_S

Row = dict[str, Any]


def _signed(value: float | None) -> str:
    return "–" if value is None else f"{value:+.2f}"


COLUMNS: tuple[tuple[str, str, Callable[[Any], str]], ...] = (
    ("method", "method", str),
    ("effect ÷ copy", "effect_to_copy", lambda v: number(v, 3)),
    ("frame ÷ plain", "frame_to_plain", lambda v: number(v, 3)),
    ("frame ms", "frame_ms", lambda v: number(v, 3)),
    ("PSNR R1 dB", "psnr_db", lambda v: number(v, 3)),
    ("FLIP R1", "flip", lambda v: number(v, 2)),
    ("SSIM R1", "ssim", lambda v: "–" if v is None else f"{v:.4f}"),
    ("PSNR R2 dB", "filter_psnr_db", lambda v: number(v, 3)),
    ("FLIP R2", "filter_flip", lambda v: number(v, 2)),
    ("rivalry", "rivalry", lambda v: number(v, 2)),
    ("shower door", "shower_door", _signed),
    ("CoC mismatch px", "coc_mismatch_px", lambda v: number(v, 2)),
    ("split-half", "split_half", lambda v: number(v, 2)),
    ("counts", "counts", lambda v: "yes" if v else "no"),
)
"""Heading, key and format of each column of the main table."""


AT_THIS_SIZE = (
    "These figures hold at this size of image: at another, shower door may have the other sign, "
    "that of R2 too."
)

FLAT = 1e-9
"""Slopes nearer to 0 are what rounding makes of equal errors."""


AGAIN = ("copy_again", "plain_again")
"""What is timed twice."""

WIDEST_AGAIN = 0.10
"""Costs of a run in which the same work twice differs by more are not to be believed."""


def number(value: float | None, digits: int) -> str:
    """Return a number with so many significant digits and without exponent; a dash for none."""
    if value is None:
        return "–"
    if value == 0:
        return "0"
    value = float(f"{value:.{digits}g}")
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{decimals}f}"


def markdown(found: dict[str, Any]) -> str:
    """Return all tables and what they mean."""
    parts = [
        f"Measured by `vrcomfort tradeoff` {found['vrcomfort']} on {found['device']} "
        f"({found['machine']}); times: {found['timer']}.",
        *(f"- {line}" for line in notes(found)),
    ]
    for key in dict.fromkeys((row["scene"], row["effect"]) for row in found["table"]):
        rows = [row for row in found["table"] if (row["scene"], row["effect"]) == key]
        parts += ["", f"### {title(*key)}", "", *_table(rows)]
    parts += ["", "### Ours against each source", "", headline(found), "", *_verdicts(found)]
    parts += ["", "### Both eyes", "", *[f"- {line}" for line in both_eyes(found)]]
    parts += ["", "### Dials", "", *[f"- {line}" for line in dials(found)], ""]
    return "\n".join(parts)


def title(scene: str, effect: str) -> str:
    """Return the heading of a scene and an effect."""
    return f"{scene}, {effect.replace('_', ' ')}"


def notes(found: dict[str, Any]) -> list[str]:
    """Return what a reader must know of the conditions, one sentence each."""
    scope, settings = found["scope"], found["settings"]
    width, height = scope["size_px"]
    poses = scope["poses"]
    return [
        f"{width}×{height} px per eye, {poses} view{'s' if poses > 1 else ''} of each scene's walk "
        f"(each where the head is fastest in its part); motion blur {_motions(scope['motions'])}. "
        "Errors are means over views and both eyes, on linear HDR light times the scene's "
        "exposure, PSNR with peak 1.",
        f"Lens: focus {settings['focus_m']} m, {settings['lens']['max_radius_percent']} % of the "
        f"image's width at {settings['lens']['full_blur_dioptre']} D. Shutter fully open.",
        f"R1: {scope['samples']} samples (a quarter for motion blur alone), the scene drawn again "
        "for each; R2: ideal scatter of "
        "the pinhole image. R1 − R2 (the row of R2) is the error of the model, R2 − method that "
        "of the filter. `split-half` is R1's own error in parts of the method's; the row counts "
        "where it is at most 0.1.",
        "effect ÷ copy: all passes after the scene's first drawing, in times of copying the "
        "stereo frame (RGBA16F, read once and written once) in the same run.",
        f"Times are medians of {scope['rounds']} frames; a method whose frames take more than "
        f"{SLOW_S:g} s is timed once, and one whose frames have taken {LONGEST_S:g} s no more. "
        f"`tradeoff.csv` has the 95th percentile of the effect's time from {P95_ROUNDS} frames on "
        f"and the 99th from {P99_ROUNDS}.",
        *_again(found["copy"]),
    ]


def _motions(motions: Sequence[str]) -> str:
    words = {
        "still": "at rest",
        "walk": "as walked",
        "turn": f"with the head turning at {TURN_DEG_PER_S:g}°/s",
    }
    return " and ".join(words[motion] for motion in motions)


def _again(copies: Sequence[Row]) -> list[str]:
    if not copies:
        return []
    copy, plain = (
        (min(each[name][0] for each in copies), max(each[name][1] for each in copies))
        for name in AGAIN
    )
    told = [
        f"A/A of this run (5–95 % of the ratio of the same work twice): copies "
        f"{copy[0]:.2f}–{copy[1]:.2f}, plain frames {plain[0]:.2f}–{plain[1]:.2f}."
    ]
    return [*told, *doubts(copies)]


def doubts(copies: Sequence[Row]) -> list[str]:
    """Say in one sentence that times are not to be believed, where the same work twice differs."""
    ratios = [r for each in copies for name in AGAIN for r in each[name]]
    widest = max((abs(ratio - 1) for ratio in ratios), default=0.0)
    if widest <= WIDEST_AGAIN:
        return []
    return [
        f"Do not believe these costs: the same work done twice differs by up to {widest:.0%}, more "
        f"than {WIDEST_AGAIN:.0%} (A/A, 5–95 %); close other programs, and measure again with more "
        "--rounds."
    ]


def _beaten(row: Row) -> str:
    parts = ["yes" if row["beaten"] else f"no: {number(row['factor'], 3)}×"]
    parts += ["within A/A"] if row["undecided"] else []
    parts += [] if row["counts"] else ["does not count"]
    return ", ".join(parts)


VERDICT_COLUMNS: tuple[tuple[str, Callable[[Row], str]], ...] = (
    ("scene, effect", lambda v: title(v["scene"], v["effect"])),
    ("against", lambda v: str(v["theirs"])),
    ("error", lambda v: str(v["error"]).upper()),
    ("nearest of ours", lambda v: str(v["ours"])),
    ("its cost ÷ theirs", lambda v: number(v["cost_ratio"], 2)),
    ("its error ÷ theirs", lambda v: number(v["error_ratio"], 2)),
    ("both faster and closer", _beaten),
)
"""Heading and text of each column of the verdicts."""


def headline(found: dict[str, Any]) -> str:
    """Return in how many comparisons one of ours is both faster and closer, and what they are."""
    verdicts = found["verdicts"]
    if not verdicts:
        return "No source's method was compared with one of ours."
    parts = []
    for error in ("rms", "flip"):
        mine = [v for v in verdicts if v["error"] == error]
        parts.append(f"{sum(v['beaten'] for v in mine)} of {len(mine)} by {error.upper()}")
    low, high = found["again"]
    return (
        f"One of ours is both faster and closer than a source's method in {' and '.join(parts)}; "
        f"in {sum(v['counts'] for v in verdicts)} of these {len(verdicts)} comparisons both rows "
        f"count, and in {sum(v['undecided'] for v in verdicts)} the verdict lies within the A/A "
        f"interval of copies ({low:.2f}–{high:.2f}), where noise alone could turn it. "
        "Where ours is not, the last column says by what factor the nearest of ours fails (the "
        "larger of both ratios)."
    )


def both_eyes(found: dict[str, Any]) -> list[str]:
    """Return one sentence on the binocular errors of the closest of ours, for each scene."""
    lines = []
    for key in dict.fromkeys((row["scene"], row["effect"]) for row in found["table"]):
        rows = [row for row in found["table"] if (row["scene"], row["effect"]) == key]
        ours = [r for r in rows if r["family"] == "ours" and r["rivalry"] is not None]
        theirs = [row["rivalry"] for row in rows if row["family"] == "source"]
        if not ours:
            continue
        best = min(ours, key=lambda row: row["rms"])
        ideal = next(row for row in rows if row["method"] == SCATTER)
        ratios = [f"{number(_ratio(best['rivalry'], ideal['rivalry']), 2)} × that of R2"]
        if theirs:
            least = _ratio(best["rivalry"], min(theirs))
            ratios.append(f"{number(least, 2)} × the least of the sources' methods")
        lines.append(
            f"{title(*key)}: rivalry of *{best['method']}* is {' and '.join(ratios)}; shower door "
            f"{_signed(best['shower_door'])} (R2 {_signed(ideal['shower_door'])}), CoC mismatch "
            f"{number(best['coc_mismatch_px'], 2)} px."
        )
    return [*lines, *([AT_THIS_SIZE] if lines else [])]


def _ratio(a: float, b: float) -> float | None:
    return a / b if b else None


def dials(found: dict[str, Any]) -> list[str]:
    """Return one sentence for each dial."""
    return [f"{title(row['scene'], row['effect'])}: {_dial(row)}." for row in found["dials"]]


def _dial(row: Row) -> str:
    steps = f"{row['dial']} = {row['steps'][0]}…{row['steps'][-1]}"
    if row["slope"] is not None and abs(row["slope"]) < FLAT:
        return f"error does not change with {steps}"
    falls = "falls at every step" if row["falls"] else "does not fall at every step"
    line = f"error {falls} of {steps}; log-log slope {number(row['slope'], 2)}"
    sure = row["steps_that_count"]
    if sure == row["steps"]:
        return line
    if row["slope_that_counts"] is None:
        where = f"at {sure[0]} alone" if sure else "nowhere"
        return f"{line} (R1 counts {where}: the slope rests on rows that do not)"
    slope = 0.0 if abs(row["slope_that_counts"]) < FLAT else row["slope_that_counts"]
    return f"{line} ({number(slope, 2)} up to {sure[-1]}, where R1 counts)"


def _table(rows: Sequence[Row]) -> list[str]:
    names = [heading for heading, _, _ in COLUMNS]
    return _lines(names, [[show(row[key]) for _, key, show in COLUMNS] for row in rows])


def _verdicts(found: dict[str, Any]) -> list[str]:
    if not found["verdicts"]:
        return []
    names = [heading for heading, _ in VERDICT_COLUMNS]
    return _lines(names, [[show(v) for _, show in VERDICT_COLUMNS] for v in found["verdicts"]])


def _lines(names: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(line)} |" for line in [names, ["---"] * len(names), *rows]]
