"""Figures of rating time courses and of survival."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from vrcomfort.plurals import counted
from vrcomfort.report.canvas import (
    FAINT,
    GRID,
    INK,
    LEGEND,
    PAPER,
    SOFT,
    Drawing,
    canvas,
    dots,
    lines,
    threads,
    time_unit,
)
from vrcomfort.report.palette import colour_of, marker_of
from vrcomfort.report.ratings.survival import (
    TimeToEvent,
    curve_of,
    repeated,
    times_to_threshold,
    times_to_withdrawal,
)
from vrcomfort.report.ratings.time_courses import at_times

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vrcomfort.report.rated_exposures import RatedExposure
    from vrcomfort.report.ratings.analysis import TimeCourseAnalysis
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.survival import KaplanMeier

    Floats = NDArray[np.float64]

MOST_LINES = 200
"""Exposures of a condition that are drawn one by one; evenly taken of more."""
MOST_BANDS = 4
"""Conditions whose intervals can be told apart in one panel."""
COLUMNS = 3
STEPS = (1, 2, 5, 10)
"""Of ticks of time."""


def rating_figures(courses: TimeCourseAnalysis, words: Vocabulary) -> dict[str, Drawing | None]:
    """Return name → drawing of rating time courses, and of times to a rating and to withdrawal."""
    found, confidence = courses.ratings, courses.confidence
    drawn: dict[str, Drawing | None] = {"ratings": course_figure(courses, words)}
    if found is not None and found.reached and found.reached[0].found.came:
        events = times_to_threshold(
            courses.exposures, found.threshold, found.threshold_rule.threshold_in_a_row
        )
        title = f"share below a rating of {found.threshold:g}"
        drawn["survival_rating"] = survival_figure(
            "reached_curves", events, title, words, confidence
        )
    if courses.leaving is not None:
        events = times_to_withdrawal(courses.exposures)
        drawn["survival_leaving"] = survival_figure(
            "leaving_curves", events, "share that went on", words, confidence
        )
    return drawn


def course_figure(courses: TimeCourseAnalysis, words: Vocabulary) -> Drawing | None:
    """Draw the means together, and each condition with its exposures; None without ratings."""
    found, curves = courses.ratings, courses.curves
    if found is None or curves is None or not curves.times_s.size:
        return None
    rows = -(-len(courses.conditions) // COLUMNS)
    several = len(courses.conditions) > 1
    height = (2.9 if several else 0.4) + (2.0 if several else 2.9) * rows
    scale, unit = time_unit(float(curves.times_s.max()))
    with canvas("ratings", 6.8, height, "rating_curves", "rated_exposures") as (figure, drawing):
        panels = _course_panels(figure, len(courses.conditions), rows)
        if several:
            together = panels.pop(0)
            _draw_together(together, courses, words, scale)
            together.set_xlabel(f"time in exposure ({unit})")
            together.set_ylabel(f"mean {found.short} rating")
        for place, axes in enumerate(panels):
            _draw_condition(axes, courses, place, words, scale)
            first = place % COLUMNS == 0
            axes.tick_params(labelleft=first)
            if first:
                axes.set_ylabel(f"{found.short} rating")
            if place + COLUMNS >= len(panels):
                axes.set_xlabel(f"time in exposure ({unit})")
        gone = [e.ended_s for e in courses.exposures if e.left]
        longest = max([float(curves.times_s.max()), *gone])
        _limits(panels, found.low, found.high, longest / scale)
    return drawing


def _course_panels(figure: Figure, count: int, rows: int) -> list[Axes]:
    """Return the panel of all conditions, where there are several, and one for each."""
    if count == 1:
        return [figure.add_subplot()]
    columns = min(count, COLUMNS)
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[1.35, *[1.0] * rows])
    panels = [figure.add_subplot(grid[0, :])]
    panels += [figure.add_subplot(grid[1 + i // columns, i % columns]) for i in range(count)]
    return panels


def _limits(panels: list[Axes], low: float, high: float, longest: float) -> None:
    room = 0.08 * (high - low or 1.0)
    for axes in panels:
        axes.set_ylim(low - room, high + room)
        axes.set_xlim(0, longest * 1.02)
        axes.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=STEPS))
        axes.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
        axes.grid(axis="y", color=GRID)
        axes.set_axisbelow(True)


def _draw_together(
    axes: Axes, courses: TimeCourseAnalysis, words: Vocabulary, scale: float
) -> None:
    curves = courses.curves
    if curves is None:
        return
    bands = len(courses.conditions) <= MOST_BANDS
    every = max(curves.times_s.size // 8, 1)
    for row, condition in enumerate(courses.conditions):
        place, shift = words.place(condition), row * every // max(len(courses.conditions), 1)
        x = curves.times_s / scale
        if bands:
            _band(axes, x, courses, row, colour_of(place))
        axes.plot(x, curves.mean[row], "-", color=colour_of(place), lw=1.8,
                  marker=marker_of(place), markevery=(shift, every), ms=5, mec=PAPER, mew=0.6,
                  label=lines(words.condition(condition), LEGEND))  # fmt: skip
        if courses.carried is not None:
            axes.plot(x, courses.carried.mean[row], color=colour_of(place), lw=1.0,
                      ls=(0, (3, 2)))  # fmt: skip
    if courses.carried is not None:
        axes.plot([], [], color=INK, lw=1.0, ls=(0, (3, 2)), label="carried forward")
    axes.set_ylim(bottom=0 if np.nanmin(curves.mean) >= 0 else None)
    axes.set_xlim(0, float(curves.times_s.max()) / scale * 1.02)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=STEPS))
    axes.grid(axis="y", color=GRID)
    axes.set_axisbelow(True)
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)


def _band(axes: Axes, x: Floats, courses: TimeCourseAnalysis, row: int, colour: str) -> None:
    curves = courses.curves
    if curves is None:
        return
    mean, half = curves.mean[row], curves.half[row]
    low, high = (np.clip(ends, *courses.scale) for ends in (mean - half, mean + half))
    axes.fill_between(x, low, high, where=(~np.isnan(half)).tolist(), color=colour, alpha=0.16,
                      lw=0)  # fmt: skip


def _draw_condition(
    axes: Axes, courses: TimeCourseAnalysis, row: int, words: Vocabulary, scale: float
) -> None:
    curves, condition = courses.curves, courses.conditions[row]
    if curves is None:
        return
    colour = colour_of(words.place(condition))
    met = [e for e in courses.exposures if e.condition == condition and e.course.times_s.size]
    shown = met[:: -(-len(met) // MOST_LINES) or 1]
    x = curves.times_s / scale
    values = at_times(shown, curves.times_s, carried=False)
    threads(axes, x, values, color=colour, lw=0.6, alpha=0.35)
    alone = np.flatnonzero((~np.isnan(values)).sum(axis=1) == 1)
    for one in alone:  # a line of one point is not seen
        dots(axes, x, values[one], colour, size=3.0, alpha=0.5)
    _band(axes, x, courses, row, colour)
    axes.plot(x, curves.mean[row], color=colour, lw=2.2)
    _mark(axes, shown, scale)
    people = len({e.participant for e in met})
    count = counted(len(met), "exposures")
    who = f", {people} people" if people != len(met) else ""
    axes.set_title(f"{lines(words.condition(condition), 26)}\n{count}{who}", fontsize=8)


def _mark(axes: Axes, exposures: list[RatedExposure], scale: float) -> None:
    """Mark withdrawals, missed ratings, and times of a frozen picture."""
    gone = [e for e in exposures if e.left]
    last = [(e.ended_s / scale, e.course.last()) for e in gone]
    known = [(t, v) for t, v in last if v is not None]
    if known:
        axes.plot(*zip(*known, strict=True), "X", color=INK, ms=5.5, mec=PAPER, mew=0.6, zorder=5)
    times = [e.course.times_s[np.isnan(e.course.ratings)] for e in exposures]
    missed = np.concatenate([np.empty(0), *times])  # a condition may have none that was rated
    if missed.size:
        foot = np.full(missed.size, 0.03)
        axes.plot(missed / scale, foot, "|", color=SOFT, ms=5, mew=0.7,
                  transform=axes.get_xaxis_transform())  # fmt: skip
    still = [when / scale for e in exposures for when, _ in e.freezes]
    if still:
        axes.plot(still, np.full(len(still), 0.03), "s", color=FAINT, ms=3.5,
                  transform=axes.get_xaxis_transform())  # fmt: skip


MOST_SURVIVAL_BANDS = 3
"""Steps overlap more than curves do."""


def survival_figure(
    table: str, events: list[TimeToEvent], title: str, words: Vocabulary, confidence: float
) -> Drawing | None:
    """Draw the share without the event over time; None without time at risk.

    Parameters
    ----------
    table
        Name of the CSV table with its curves.
    title
        Label of the axis.
    """
    shown = [c for c in words.labels if any(e.condition == c for e in events)]
    shown += [""] if any(not e.condition for e in events) else []
    if not shown or max(e.time_s for e in events) <= 0:
        return None
    robust = repeated(events)
    curves = {
        condition: curve_of([e for e in events if e.condition == condition], confidence,
                            robust=robust)
        for condition in shown
    }  # fmt: skip
    longest = max(e.time_s for e in events)
    scale, unit = time_unit(longest)
    with canvas(f"survival-{table}", 6.4, 3.1 + 0.17 * len(shown), table) as (figure, drawing):
        above, below = _survival_panels(figure, len(shown))
        for condition, curve in curves.items():
            _draw_survival(
                above, curve, condition, words, scale, band=len(shown) <= MOST_SURVIVAL_BANDS
            )
        above.set_ylim(-0.02, 1.04)
        above.set_xlim(0, longest / scale * 1.02)
        above.xaxis.set_major_locator(MaxNLocator(nbins=6, steps=STEPS))
        above.set_ylabel(title)
        above.grid(axis="y", color=GRID)
        above.set_axisbelow(True)
        if len(shown) > 1:
            above.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1),
                         fontsize=8)  # fmt: skip
        _at_risk(below, above, curves, words, scale)
        below.set_xlabel(f"time in exposure ({unit}); below the curves, exposures at risk")
    return drawing


def _survival_panels(figure: Figure, rows: int) -> tuple[Axes, Axes]:
    grid = figure.add_gridspec(2, 1, height_ratios=[2.6, 0.17 * rows])
    above = figure.add_subplot(grid[0])
    below = figure.add_subplot(grid[1], sharex=above)
    above.tick_params(labelbottom=True)
    return above, below


def _draw_survival(
    axes: Axes, curve: KaplanMeier, condition: str, words: Vocabulary, scale: float, *, band: bool
) -> None:
    known = condition in words.labels
    colour = colour_of(words.place(condition)) if known else INK
    x = np.concatenate([[0.0], curve.times_s / scale])
    share = np.concatenate([[1.0], curve.survival])
    label = lines(words.condition(condition), LEGEND) if condition else "all"
    shape = marker_of(words.place(condition)) if known else "o"
    axes.step(x, share, where="post", color=colour, lw=1.8, label=label, marker=shape,
              markevery=[-1], ms=5, mec=PAPER, mew=0.5)  # fmt: skip
    if band:
        low = np.concatenate([[1.0], curve.low])
        high = np.concatenate([[1.0], curve.high])
        axes.fill_between(x, low, high, step="post", color=colour, alpha=0.14, lw=0)
    left = np.append(curve.at_risk[1:], 0)
    censored = np.flatnonzero(curve.at_risk - curve.events > left)
    axes.plot(curve.times_s[censored] / scale, curve.survival[censored], "|", color=colour, ms=6)


def _at_risk(
    below: Axes, above: Axes, curves: dict[str, KaplanMeier], words: Vocabulary, scale: float
) -> None:
    ticks = [t for t in above.get_xticks() if 0 <= t <= above.get_xlim()[1]]
    for row, (condition, curve) in enumerate(curves.items()):
        known = condition in words.labels
        colour = colour_of(words.place(condition)) if known else INK
        if known and len(curves) > 1:
            shape = marker_of(words.place(condition))
            below.plot(-0.035, -row, shape, color=colour, ms=5, clip_on=False,
                       transform=below.get_yaxis_transform())  # fmt: skip
        for tick in ticks:
            still = int(np.searchsorted(curve.times_s, tick * scale - 1e-9))
            count = int(curve.at_risk[still]) if still < curve.at_risk.size else 0
            below.text(tick, -row, f"{count}", ha="center", va="center", color=colour, fontsize=8)
    below.set_ylim(-len(curves) + 0.4, 0.6)
    below.set_yticks([])
    below.tick_params(axis="both", length=0, labelbottom=False)
    for side in ("left", "bottom"):
        below.spines[side].set_visible(False)
