"""Kaplan–Meier curves of conditions, with the numbers at risk below them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from vrcomfort.report.canvas import GRID, INK, LEGEND, PAPER, Drawing, canvas, lines
from vrcomfort.report.courses.course_figure import STEPS, time_unit
from vrcomfort.report.courses.events import Event, curve_of, repeated
from vrcomfort.report.palette import colour_of, marker_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.survival import KaplanMeier

MOST_BANDS = 3
"""Conditions whose intervals can be told apart."""


def survival_figure(
    name: str, events: list[Event], title: str, words: Vocabulary, confidence: float
) -> Drawing | None:
    """Draw the share without the event over time; None where nothing was watched.

    Parameters
    ----------
    title
        What the share is of, for the axis.
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
    with canvas(name, 6.4, 3.1 + 0.17 * len(shown)) as (figure, drawing):
        above, below = _panels(figure, len(shown))
        for condition, curve in curves.items():
            _draw(above, curve, condition, words, scale, band=len(shown) <= MOST_BANDS)
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


def _panels(figure: Figure, rows: int) -> tuple[Axes, Axes]:
    grid = figure.add_gridspec(2, 1, height_ratios=[2.6, 0.17 * rows])
    above = figure.add_subplot(grid[0])
    below = figure.add_subplot(grid[1], sharex=above)
    above.tick_params(labelbottom=True)
    return above, below


def _draw(
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
