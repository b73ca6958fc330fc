"""Figures as SVG text: the same data give the same bytes."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from textwrap import fill
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.stats import t as t_distribution

from vrcomfort.report.descriptives import of_the_tested
from vrcomfort.report.ordering import natural
from vrcomfort.report.pairs import Side, pair_up
from vrcomfort.report.study_data import trial_s
from vrcomfort.web_page import visible

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from vrcomfort.report.exposures import Exposures

COLOURS = ("#b4541a", "#20639b", "#3a7d44", "#7d4f9e", "#8a7a2f", "#5b5b5b")
"""One per condition, of similar lightness and told apart by people with any colour vision."""
INK, FAINT = "#222222", "#9a9a9a"

_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "svg.fonttype": "path",
    "text.parse_math": False,  # a name with two dollars is a name, not a formula
}
MOST_SUBSCALES = 6
"""Beside each other in one figure."""
LONGEST_NAME, LONGEST_WORD, LEGEND = 60, 30, 30
"""Letters that a figure has room for: of a name, of a word in one piece, of a legend's line."""


def short(name: str) -> str:
    """Return a name as a figure writes it: every character visible, cut where it is long."""
    name = visible(name)
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def lines(name: str, width: int) -> str:
    """Return a name in lines of about `width` letters."""
    name = short(name)
    broken = any(len(word) > LONGEST_WORD for word in name.split())
    return fill(name, width, break_long_words=broken)


@contextmanager
def canvas(name: str, width: float, height: float) -> Iterator[tuple[Figure, list[str]]]:
    """Give a figure to draw on; its SVG text is appended to the list afterwards."""
    text: list[str] = []
    with mpl.rc_context({**_STYLE, "svg.hashsalt": name}), warnings.catch_warnings():
        # A box stands for a letter that the font does not have; the page's tables have the letter.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasSVG(figure)
        yield figure, text
        stream = io.StringIO()
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        text.append(stream.getvalue())


def score_label(basis: str) -> str:
    """Return what the axis of a score says."""
    return "change from baseline" if basis == "difference_from_baseline" else "score after exposure"


def paired_figure(
    scored: Exposures,
    a: Side,
    b: Side,
    *,
    labels: dict[str, str],
    outcome: str,
    complete: bool,
) -> str | None:
    """Scores under two conditions, a line per participant over a box (Carnegie & Rhee, Fig. 9)."""
    pairs = pair_up(scored, outcome, a, b, complete=complete)
    if not pairs.participants:
        return None
    scores = np.column_stack([pairs.b, pairs.a]) * pairs.unit
    with canvas(f"paired-{a.name}-{b.name}-{outcome}", 4.6, 4.2) as (figure, text):
        axes = figure.add_subplot()
        _boxes(axes, scores, (labels[b.name], labels[a.name]))
        up, down = scores[:, 1] > scores[:, 0], scores[:, 1] < scores[:, 0]
        for mask, colour in ((up, COLOURS[0]), (down, COLOURS[1]), (~(up | down), FAINT)):
            if mask.any():
                axes.plot(*_segments(scores[mask]), "-o", color=colour, lw=1, ms=3.5, alpha=0.75)
        axes.set_ylabel(f"{scored.titles[outcome].lower()}, {score_label(scored.basis)}")
        _count_directions(axes, int(up.sum()), int(down.sum()), len(scores))
        _zero_line(axes, scored.basis)
    return text[0]


def _segments(scores: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return one line for all, broken between participants: a line each is slow for a thousand."""
    broken = np.column_stack([scores, np.full(len(scores), np.nan)])
    return np.tile([1.0, 2.0, np.nan], len(scores)), broken.ravel()


def _boxes(axes: Axes, scores: np.ndarray[Any, Any], names: tuple[str, ...]) -> None:
    axes.boxplot(
        scores, positions=[0.72, 2.28], widths=0.2, whis=(0, 100), patch_artist=True,
        boxprops={"facecolor": "#eeeeee", "edgecolor": "#777777"},
        medianprops={"color": INK, "lw": 1.8}, whiskerprops={"color": "#777777"},
        capprops={"color": "#777777"},
    )  # fmt: skip
    axes.plot([0.72, 2.28], scores.mean(axis=0), "D", color=INK, ms=4, zorder=5)
    axes.set_xticks([1, 2], [lines(name, 20) for name in names])
    axes.set_xlim(0.45, 2.55)


def _count_directions(axes: Axes, up: int, down: int, n: int) -> None:
    words = f"higher on the right: {up}   lower: {down}   equal: {n - up - down}"
    axes.set_title(words, fontsize=8, color="#555555", loc="left")


def _zero_line(axes: Axes, basis: str) -> None:
    if basis == "difference_from_baseline":
        axes.axhline(0, color=FAINT, lw=0.8, ls=(0, (4, 3)), zorder=0)


def subscale_figure(
    table: pd.DataFrame, results: dict[str, Any], weights: dict[str, float]
) -> str | None:
    """Subscales by condition: everybody's score, the mean and its 95 % interval (Fig. 8)."""
    first = results["outcomes"][0]
    alike = [o for o in results["outcomes"] if o["instrument"] == first["instrument"]]
    outcomes = [o["name"] for o in alike if not o["parts"]][:MOST_SUBSCALES]
    titles = {o["name"]: o["title"] for o in alike}
    analysed = table[table["participant"].isin(results["participants"]["analysed"])]
    if analysed.empty or not outcomes:
        return None
    conditions = results["conditions"]
    with canvas("subscales", 2.6 * len(outcomes) + 0.4, 3.4) as (figure, text):
        for axes, outcome in zip(
            np.atleast_1d(figure.subplots(1, len(outcomes), sharey=True)), outcomes, strict=True
        ):
            for place, condition in enumerate(conditions):
                chosen = _of_condition(analysed, results, condition["name"], outcome)
                means = chosen.groupby("participant")[outcome].mean() * weights[outcome]
                _mean_and_points(axes, place, means.to_numpy(dtype=float))
            axes.set_title(titles[outcome], fontsize=9.5)
            _name_conditions(axes, conditions)
            _zero_line(axes, results["score_basis"])
        figure.axes[0].set_ylabel(score_label(results["score_basis"]))
    return text[0]


def _of_condition(
    table: pd.DataFrame, results: dict[str, Any], condition: str, outcome: str
) -> pd.DataFrame:
    """Return the exposures of those tested under a condition; of all if nothing is compared."""
    if results["tests"]:
        return of_the_tested(table, results["tests"], condition, outcome)
    return table[table["condition"] == condition]


def _name_conditions(axes: Axes, conditions: list[dict[str, str]]) -> None:
    room = 28 // len(conditions)
    names = [lines(c["label"], max(room, 8)) for c in conditions]
    axes.set_xticks(range(len(conditions)), names, fontsize=8)
    axes.set_xlim(-0.6, len(conditions) - 0.4)


def _mean_and_points(axes: Axes, place: int, scores: np.ndarray[Any, Any]) -> None:
    if not scores.size:
        return
    colour = COLOURS[place % len(COLOURS)]
    spread = np.linspace(-0.16, 0.16, scores.size) if scores.size > 1 else np.zeros(1)
    axes.plot(place + spread, scores, "o", color=colour, ms=3.5, alpha=0.4, mew=0)
    half = 0.0
    if scores.size > 1:
        error = scores.std(ddof=1) / np.sqrt(scores.size)
        half = float(t_distribution.ppf(0.975, scores.size - 1) * error)
    axes.errorbar(place, scores.mean(), half, fmt="D", color=colour, ms=6, capsize=4, lw=1.8,
                  mec="white", mew=0.8, zorder=5)  # fmt: skip


def symptom_figure(results: dict[str, Any]) -> str | None:
    """Mean answer of each symptom by condition (Fig. 7), the largest first."""
    conditions = results["conditions"]
    items = [i for i in results["items"] if i["instrument"] == results["items"][0]["instrument"]]
    if not items:
        return None
    asked = next(i for i in results["instruments"] if i["name"] == items[0]["instrument"])
    names = [c["name"] for c in conditions if c["name"] in items[0]]
    if not names:
        return None
    ranked = sorted(items, key=lambda item: max(item[name] for name in names))
    with canvas("symptoms", 6.4, 4.6) as (figure, text):
        axes = figure.add_subplot()
        for row, item in enumerate(ranked):
            values = [item[name] for name in names]
            axes.plot([min(values), max(values)], [row, row], color="#cccccc", lw=2, zorder=1)
        for place, condition in enumerate(conditions):
            if condition["name"] in names:
                rows = np.arange(len(ranked)) + 0.7 / len(names) * ((len(names) - 1) / 2 - place)
                axes.plot([i[condition["name"]] for i in ranked], rows,
                          "osD^vP"[place % 6], color=COLOURS[place % len(COLOURS)], ms=6,
                          mec="white", mew=0.6, label=lines(condition["label"], LEGEND),
                          zorder=3)  # fmt: skip
        wording = {item["name"]: lines(item["text"], 44) for item in asked["items"]}
        axes.set_yticks(range(len(ranked)), [wording[i["item"]] for i in ranked])
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x", color="#eeeeee")
        axes.set_axisbelow(True)
        axes.set_xlabel(f"mean answer ({asked['answers']}), {score_label(results['score_basis'])}")
        if results["score_basis"] == "difference_from_baseline":
            axes.axvline(0, color=FAINT, lw=0.8)
        axes.legend(frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    return text[0]


def exposure_figure(trials: list[dict[str, str]], results: dict[str, Any]) -> str | None:
    """Everybody's exposures in order, with a cross where somebody left; only if somebody did."""
    if not results["withdrawals"]["n"] or not trials:
        return None
    people = sorted({t["participant"] for t in trials}, key=natural)
    gone = {each["participant"] for each in results["withdrawals"]["list"]}
    place = {c["name"]: i for i, c in enumerate(results["conditions"])}
    with canvas("exposures", 6.8, 0.8 + 0.21 * len(people)) as (figure, text):
        axes = figure.add_subplot()
        for row, person in enumerate(reversed(people)):
            mine = [t for t in trials if t["participant"] == person]
            mine.sort(key=lambda t: (natural(t["session"]), natural(t["trial"])))
            _exposures_of(axes, row, mine, place, withdrew=person in gone)
        for condition in results["conditions"]:
            colour = COLOURS[place[condition["name"]] % len(COLOURS)]
            axes.barh(0, 0, color=colour, alpha=0.8, label=lines(condition["label"], LEGEND))
        axes.plot([], [], "X", color=INK, ms=7, ls="", label="withdrew here")
        axes.set_yticks(range(len(people)), [*map(short, reversed(people))], fontsize=7.5)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel(f"time in exposure, all sessions ({_unit(trials)[1]})")
        axes.xaxis.set_major_locator(MaxNLocator(nbins=8))
        columns = 3 if len(place) < 3 else 2
        axes.legend(
            frameon=False, ncols=columns, loc="lower left", bbox_to_anchor=(0, 1), fontsize=8
        )
    return text[0]


def _unit(trials: list[dict[str, str]]) -> tuple[float, str]:
    longest = max(trial_s(t) or 0.0 for t in trials)
    return (60.0, "min") if longest >= 90 else (1.0, "s")


def _exposures_of(
    axes: Axes, row: int, trials: list[dict[str, str]], place: dict[str, int], *, withdrew: bool
) -> None:
    scale, start = _unit(trials)[0], 0.0
    for trial in trials:
        length = (trial_s(trial) or 0.0) / scale
        colour = COLOURS[place.get(trial["condition"], 5) % len(COLOURS)]
        axes.barh(row, length, left=start, height=0.62, color=colour, alpha=0.8,
                  edgecolor="white", lw=1.2)  # fmt: skip
        start += length
    if withdrew:
        axes.plot(start, row, "X", color=INK, ms=7, mec="white", mew=0.8, zorder=5)
