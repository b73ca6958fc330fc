"""One course of ratings during an exposure, and the numbers that sum it up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

SECONDS_PER_MINUTE = 60.0


@dataclass(frozen=True)
class Reached:
    """When a course first reached a threshold, or how long it was watched without that."""

    time_s: float
    reached: bool
    """False: the course ended (was censored) at `time_s`, below the threshold."""


@dataclass(frozen=True)
class RatingCourse:
    """Ratings of one exposure in the order of their times; make one with `of`.

    Summaries are of answered ratings. They are None where no rating was answered, the slope also
    where all were answered at one time.
    """

    times_s: Floats
    """Since the exposure began, shape (n,), ascending."""
    ratings: Floats
    """Shape (n,); NaN where a rating was missed."""

    @classmethod
    def of(cls, times_s: ArrayLike, ratings: ArrayLike) -> RatingCourse:
        """Sort ratings by their times; those of one time keep their order.

        Raises
        ------
        InputError
            If the two differ in length, or a time is not finite.
        """
        times = np.asarray(times_s, dtype=np.float64)
        values = np.asarray(ratings, dtype=np.float64)
        if times.ndim != 1 or times.shape != values.shape:
            raise InputError("a course needs one time for each rating")
        if not np.isfinite(times).all():
            raise InputError("a time of a rating is missing or infinite; give seconds")
        order = np.argsort(times, kind="stable")
        return cls(times[order], values[order])

    @property
    def answered(self) -> RatingCourse:
        """Return the course without the ratings that were missed."""
        there = ~np.isnan(self.ratings)
        return self if there.all() else RatingCourse(self.times_s[there], self.ratings[there])

    def peak(self) -> float | None:
        """Return the highest rating."""
        values = self.answered.ratings
        return float(values.max()) if values.size else None

    def mean(self) -> float | None:
        """Return the mean of the ratings, each counting the same whatever lies between them."""
        values = self.answered.ratings
        return float(values.mean()) if values.size else None

    def last(self) -> float | None:
        """Return the last rating: what is carried forward to the planned end."""
        values = self.answered.ratings
        return float(values[-1]) if values.size else None

    def area(self) -> float | None:
        """Return the area under the ratings in points × s, by trapezoids.

        It is that from the first to the last answered rating: nothing is said of other times. One
        rating alone has the area 0.
        """
        here = self.answered
        if not here.ratings.size:
            return None
        return float(np.trapezoid(here.ratings, here.times_s))

    def slope_per_min(self) -> float | None:
        """Return the slope of the least-squares line, in points per minute."""
        here = self.answered
        if here.ratings.size < 2 or np.ptp(here.times_s) == 0:
            return None
        minutes = here.times_s / SECONDS_PER_MINUTE
        minutes = minutes - minutes.mean()
        return float(minutes @ here.ratings / (minutes @ minutes))

    def time_to(self, threshold: float, *, ended_s: float | None = None) -> Reached | None:
        """Return when a rating was first at `threshold` or above.

        Parameters
        ----------
        ended_s
            When the exposure ended, for how long it was watched; without it, until the last
            rating, missed ones included.

        Returns
        -------
        Reached or None
            None where no rating was answered: then nothing is known of the threshold.
        """
        here = self.answered
        if not here.ratings.size:
            return None
        hit = np.flatnonzero(here.ratings >= threshold)
        if hit.size:
            return Reached(float(here.times_s[hit[0]]), reached=True)
        return Reached(float(self.times_s[-1] if ended_s is None else ended_s), reached=False)

    def carried_forward(self, at_s: ArrayLike, *, until_s: float | None = None) -> Floats:
        """Return the last rating answered at or before each time; NaN where there was none yet.

        Parameters
        ----------
        at_s
            Times since the exposure began, shape (m,).
        until_s
            From when on nothing is carried (NaN after it); without it, it is carried for ever.
        """
        here = self.answered
        at = np.asarray(at_s, dtype=np.float64)
        place = np.searchsorted(here.times_s, at, side="right") - 1
        known = place >= 0
        if until_s is not None:
            known &= at <= until_s
        values = np.full(at.shape, np.nan)
        values[known] = here.ratings[place[known]]
        return values
