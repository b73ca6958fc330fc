"""The tables as Markdown, and numbers as text."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from vrcomfort.plurals import counted
from vrcomfort.tradeoff.costs import LONGEST_S, SLOW_S
from vrcomfort.tradeoff.error_measures import REGIONS
from vrcomfort.tradeoff.measure import SCATTER
from vrcomfort.tradeoff.recommendation import Option, Recommendation
from vrcomfort.tradeoff.results import key_of_row, title
from vrcomfort.tradeoff.walk import TURN_DEG_PER_S

Row = dict[str, Any]


def _signed(value: float | None) -> str:
    return "–" if value is None else f"{value:+.2f}"


def _thousandths(value: float | None) -> str:
    return "–" if value is None else number(1e3 * value, 3)


def _count(value: float | None) -> str:
    return "–" if value is None else f"{value:.0f}"


Column: TypeAlias = tuple[str, str, Callable[[Any], str]]
"""Heading, key and format."""

COLUMNS: tuple[Column, ...] = (
    ("method", "method", str),
    ("cost", "cost", lambda v: number(v, 3)),
    ("reads / px", "reads_per_pixel", lambda v: number(v, 3)),
    ("bytes / px", "bytes_per_pixel", lambda v: number(v, 3)),
    ("passes", "passes", _count),
    ("draws", "draws", _count),
    ("RMS R1 · 10³", "rms", _thousandths),
    ("FLIP R1", "flip", lambda v: number(v, 2)),
    ("SSIM R1", "ssim", lambda v: "–" if v is None else f"{v:.4f}"),
    ("RMS R2 · 10³", "filter_rms", _thousandths),
    ("rivalry", "rivalry", lambda v: number(v, 2)),
    ("shower door", "shower_door", _signed),
    ("split-half", "split_half", lambda v: number(v, 2)),
    ("counts", "counts", lambda v: "yes" if v else "no"),
)
"""The main table."""

REGION_COLUMNS: tuple[Column, ...] = (
    ("method", "method", str),
    *((name.replace("_", " "), f"{name}_rms", _thousandths) for name in REGIONS),
    ("seams", "seams", _thousandths),
    ("off median > 2/255", "off_median_2_px", _count),
    ("> 4/255", "off_median_4_px", _count),
    ("R1's > 2/255", "reference_off_median_2_px", _count),
    ("flicker", "flicker", _thousandths),
)
"""RMS error · 10³ by region, and errors that catch the eye."""


AT_THIS_SIZE = (
    "These figures hold at this size of image: at another, shower door may have the other sign, "
    "that of R2 too."
)

FLAT = 1e-9
"""Slopes nearer to 0 come from rounding of equal errors."""


WIDEST_AGAIN = 0.10
"""Costs of a run in which the same work twice differs by more are not to be believed."""


def number(value: float | None, digits: int) -> str:
    """Return a number with `digits` significant digits and without exponent; a dash for none."""
    if value is None:
        return "–"
    if value == 0:
        return "0"
    value = float(f"{value:.{digits}g}")
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{decimals}f}"


def markdown(found: dict[str, Any]) -> str:
    """Return all tables with their notes."""
    parts = [
        f"Measured by `vrcomfort tradeoff` {found['vrcomfort']} on {found['device']} "
        f"({found['machine']}); times: {found['timer']}.",
        *(f"- {line}" for line in notes(found)),
    ]
    for key in dict.fromkeys(key_of_row(row) for row in found["table"]):
        rows = [row for row in found["table"] if key_of_row(row) == key]
        parts += ["", f"### {title(key)}", "", *_table(COLUMNS, rows)]
        if key[1] != "motion_blur":
            parts += ["", *_table(REGION_COLUMNS, rows)]
    parts += ["", "### Ours against each source", "", headline(found), "", *_verdicts(found)]
    parts += ["", "### Both eyes", "", *[f"- {line}" for line in both_eyes(found)]]
    parts += ["", "### Dials", "", *[f"- {line}" for line in dials(found)], ""]
    return "\n".join(parts)


def notes(found: dict[str, Any]) -> list[str]:
    """Return notes on the conditions, one sentence each."""
    scope, settings = found["scope"], found["settings"]
    return [
        f"{_what(scope)}, {_places(scope)} on each scene's walk "
        f"(each where the head is fastest in its part); motion blur {_motions(scope['motions'])}. "
        "Errors are means over views and eyes, on linear HDR light times the scene's exposure "
        "(display white is 1).",
        f"Focus {settings['focus_m']} m; lens: {_lenses(scope['lenses'])}. Shutter fully open.",
        f"R1: {scope['samples']} samples (a quarter for motion blur alone), the scene drawn again "
        "for each; R2: ideal scatter of "
        "the pinhole image. R1 − R2 (the row of R2) is the error of the model, R2 − method that "
        "of the filter. `split-half` is R1's own error in parts of the method's; the row counts "
        "where it is at most 0.1.",
        "cost: 1 + effect ÷ plain frame, each effect by the plain frames before and after it; "
        f"medians of {scope['rounds']} frames. A method whose first frame takes more than "
        f"{SLOW_S:g} s is timed once, and none for more than {LONGEST_S:g} s.",
        "reads: calls of texture functions for one pixel of an eye's image, whatever their filter, "
        "counted while drawing. bytes: each pass reads each of its textures once and writes what "
        "it draws. passes: runs of draws into one target; a mip chain is one.",
        *_again(found["again"]),
    ]


def _what(scope: Row) -> str:
    width, height = scope["size_px"]
    if scope["windows"]:
        return f"parts of the left eye's image of {width}×{height} px"
    return f"{width}×{height} px, {'both eyes' if scope['eyes'] == 2 else 'left eye'}"


def _places(scope: Row) -> str:
    poses, pose = scope["poses"], scope.get("pose")
    if pose is not None:
        return f"place {pose + 1} of {poses}"
    return counted(poses, "places")


def _lenses(names: Sequence[str]) -> str:
    words = [
        "an eye with a pupil of 4 mm" if name == "eye" else f"{name} % of the image's width at 2 D"
        for name in names
    ]
    return ", ".join(words)


def _motions(motions: Sequence[str]) -> str:
    words = {
        "still": "at rest",
        "walk": "as walked",
        "turn": f"with the head turning at {TURN_DEG_PER_S:g}°/s",
    }
    return " and ".join(words[motion] for motion in motions)


def _again(times: Sequence[Row]) -> list[str]:
    if not times:
        return []
    low = min(each["plain_again"][0] for each in times)
    high = max(each["plain_again"][1] for each in times)
    told = (
        "A/A of this run (5–95 % of the ratio of a plain frame to the one before it): "
        f"{low:.2f}–{high:.2f}."
    )
    return [told, *doubts(times)]


def doubts(times: Sequence[Row]) -> list[str]:
    """Say in one sentence that times are not to be believed, where the same work twice differs."""
    ratios = [ratio for each in times for ratio in each["plain_again"]]
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


PRICE_WORDS = {"cost": "cost", "reads_per_pixel": "reads", "bytes_per_pixel": "bytes"}


def _error_words(name: str) -> str:
    if name.endswith("_rms"):
        return f"RMS, {name.removesuffix('_rms').replace('_', ' ')}"
    return name.upper()


VERDICT_COLUMNS: tuple[tuple[str, Callable[[Row], str]], ...] = (
    ("scene, effect, lens", lambda v: title(key_of_row(v))),
    ("against", lambda v: str(v["theirs"])),
    ("error", lambda v: _error_words(v["error"])),
    ("at equal", lambda v: PRICE_WORDS[v["price"]]),
    ("nearest of ours", lambda v: str(v["ours"])),
    ("its price ÷ theirs", lambda v: number(v["cost_ratio"], 2)),
    ("its error ÷ theirs", lambda v: number(v["error_ratio"], 2)),
    ("both cheaper and closer", _beaten),
)
"""Heading and text of each column of the verdicts."""


OPTION_COLUMNS: tuple[tuple[str, Callable[[Option], str]], ...] = (
    ("a frame may take (ms)", lambda o: f"from {number(o.frame_ms, 3)}"),
    ("choose", lambda o: o.label),
    ("in the protocol", lambda o: "; ".join(o.lines)),
    ("plain frames", lambda o: number(o.cost, 3)),
    ("RMS · 10³", lambda o: _thousandths(o.rms)),
    ("FLIP", lambda o: number(o.flip, 2)),
)
"""Heading and text of each column of a front by its milliseconds."""


def answer(choice: Recommendation, size_px: Sequence[int]) -> str:
    """Return the recommendation in words."""
    width, height = size_px
    one = choice.front[choice.chosen]
    price = (
        f"a stereo frame of {width}×{height} px per eye then takes {number(one.frame_ms, 3)} ms "
        f"({number(one.cost, 3)} plain frames)"
    )
    error = (
        f"Its RMS error is {number(one.rms / choice.sharp_rms * 100, 2)} % of that without blur."
        if choice.sharp_rms
        else ""
    )
    budget = f"{choice.budget_ms:.3g} ms"
    if choice.fits:
        return f"For {budget} choose {one.label}: {price}. {error}"
    return (
        f"Nothing fits {budget} on this device: a plain frame takes {number(choice.plain_ms, 3)} "
        f"ms. The cheapest on the front is {one.label}: {price}. {error}"
    )


def headline(found: dict[str, Any]) -> str:
    """Return in how many comparisons one of ours is both faster and closer, and which."""
    verdicts = found["verdicts"]
    if not verdicts:
        return "No source's method was compared with one of ours."
    parts = []
    for price, word in PRICE_WORDS.items():
        mine = [v for v in verdicts if v["price"] == price]
        parts.append(f"{sum(v['beaten'] for v in mine)} of {len(mine)} by {word}")
    low, high = found["noise"]
    return (
        "One of ours is both cheaper and closer than a source's or engine's method in "
        f"{', '.join(parts)} (RMS, FLIP, near rims and far edges); "
        f"in {sum(v['counts'] for v in verdicts)} of these {len(verdicts)} comparisons both rows "
        f"count, and in {sum(v['undecided'] for v in verdicts)} the verdict lies within the A/A "
        f"interval of plain frames ({low:.2f}–{high:.2f}), where noise alone could turn it. "
        "Where ours is not, the last column says by what factor the nearest of ours fails (the "
        "larger of both ratios)."
    )


def both_eyes(found: dict[str, Any]) -> list[str]:
    """Return one sentence on the binocular errors of the closest of ours, for each scene."""
    lines = []
    for key in dict.fromkeys(key_of_row(row) for row in found["table"]):
        rows = [row for row in found["table"] if key_of_row(row) == key]
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
            f"{title(key)}: rivalry of *{best['method']}* is {' and '.join(ratios)}; shower door "
            f"{_signed(best['shower_door'])} (R2 {_signed(ideal['shower_door'])}), CoC mismatch "
            f"{number(best['coc_mismatch_px'], 2)} px."
        )
    return [*lines, *([AT_THIS_SIZE] if lines else [])]


def _ratio(a: float, b: float) -> float | None:
    return a / b if b else None


def dials(found: dict[str, Any]) -> list[str]:
    """Return one sentence for each dial."""
    return [f"{title(key_of_row(row))}: {_dial(row)}." for row in found["dials"]]


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


def _table(columns: Sequence[Column], rows: Sequence[Row]) -> list[str]:
    names = [heading for heading, _, _ in columns]
    return _lines(names, [[show(row.get(key)) for _, key, show in columns] for row in rows])


def _verdicts(found: dict[str, Any]) -> list[str]:
    if not found["verdicts"]:
        return []
    names = [heading for heading, _ in VERDICT_COLUMNS]
    return _lines(names, [[show(v) for _, show in VERDICT_COLUMNS] for v in found["verdicts"]])


def _lines(names: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(line)} |" for line in [names, ["---"] * len(names), *rows]]
