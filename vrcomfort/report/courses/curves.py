"""Mean ratings over time under each condition, with intervals that compare within people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.courses.summaries import planned_s
from vrcomfort.stats.means import MeanCurves, mean_curves

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vrcomfort.report.courses.exposures import RatedExposure

    Floats = NDArray[np.float64]

MOST_TIMES = 48
"""At which a mean is fitted: more than a figure can show apart."""


def grid_s(exposures: list[RatedExposure]) -> Floats:
    """Return the times of the means: those of ratings where they are few and alike, else even.

    Even ones end where a tenth of the exposures that nobody left had ended: means of the few that
    went on for longer would jump.
    """
    answered = [e.course.answered.times_s for e in exposures]
    together = np.concatenate(answered) if answered else np.array([])
    if not together.size:
        return together
    rounded = np.unique(np.round(together))
    if rounded.size <= MOST_TIMES:
        late = [together[np.round(together) == moment].max() for moment in rounded]
        return np.asarray(late, dtype=np.float64)
    first = max(float(np.median([each[0] for each in answered if each.size])), 0.0)
    ends = [e.course.times_s[-1] for e in exposures if not e.left] or [float(together.max())]
    last = float(np.quantile(ends, 0.1))
    return np.linspace(first, max(last, first), MOST_TIMES)


def at_times(exposures: list[RatedExposure], times_s: Floats, *, carried: bool) -> Floats:
    """Return each exposure's last rating at each time, shape (exposures, times).

    Parameters
    ----------
    carried
        Of those who left, the last rating stands until the planned end; without it, nothing is
        there after an exposure ended.
    """
    end = planned_s(exposures)
    rows = [
        e.course.carried_forward(times_s, until_s=end if carried and e.left else _until_s(e))
        for e in exposures
    ]
    return np.array(rows, dtype=np.float64).reshape(len(exposures), times_s.size)


def _until_s(exposure: RatedExposure) -> float:
    """Return until when a rating stands: the end of the exposure, and its last rating at least."""
    times = exposure.course.times_s
    return max(exposure.ended_s, float(times[-1]) if times.size else 0.0)


def condition_curves(
    exposures: list[RatedExposure],
    conditions: list[str],
    confidence: float,
    *,
    carried: bool = False,
) -> MeanCurves:
    """Return the mean of each condition over time, of the exposures that have a rating."""
    rated = [e for e in exposures if e.course.answered.ratings.size and e.condition in conditions]
    times = grid_s(rated)
    return mean_curves(
        times,
        at_times(rated, times, carried=carried),
        [conditions.index(e.condition) for e in rated],
        [e.participant for e in rated],
        count=len(conditions),
        confidence=confidence,
    )
