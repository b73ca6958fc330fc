"""Rating time courses: their summaries, and a model of symptoms that build up."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as t_distribution

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

# One course of ratings during an exposure, and the numbers that sum it up.


SECONDS_PER_MINUTE = 60.0
ROUNDING = 1e-12
"""Share of what a slope is summed from below which the sum is rounding."""


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
    gaps_s: Floats = field(default_factory=lambda: np.empty((0, 2)))
    """Times between which nothing is known, not even that ratings were missed; shape (gaps, 2)."""

    @classmethod
    def of(
        cls, times_s: ArrayLike, ratings: ArrayLike, *, gaps_s: ArrayLike | None = None
    ) -> RatingCourse:
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
        gaps = np.empty((0, 2)) if gaps_s is None else np.asarray(gaps_s, dtype=np.float64)
        if (np.diff(times) >= 0).all():
            return cls(times, values, gaps)
        order = np.argsort(times, kind="stable")
        return cls(times[order], values[order], gaps)

    @cached_property
    def answered(self) -> RatingCourse:
        """Return the course without the ratings that were missed."""
        there = ~np.isnan(self.ratings)
        if there.all():
            return self
        return RatingCourse(self.times_s[there], self.ratings[there], self.gaps_s)

    def peak(self) -> float | None:
        """Return the highest rating."""
        values = self.answered.ratings
        return float(values.max()) if values.size else None

    def mean(self) -> float | None:
        """Return the unweighted mean of the ratings."""
        values = self.answered.ratings
        return float(values.mean()) if values.size else None

    def last(self) -> float | None:
        """Return the last rating, which is carried forward to the planned end."""
        values = self.answered.ratings
        return float(values[-1]) if values.size else None

    def area(self) -> float | None:
        """Return the area under the ratings in points × s, by trapezoids.

        It is that from the first to the last answered rating: nothing is said of other times. One
        rating alone has the area 0. A course with a gap has none.
        """
        here = self.answered
        if not here.ratings.size or self.gaps_s.size:
            return None
        return float(np.trapezoid(here.ratings, here.times_s))

    def slope_per_min(self) -> float | None:
        """Return the slope of the least-squares line, in points per minute."""
        here = self.answered
        if here.ratings.size < 2 or np.ptp(here.times_s) == 0:
            return None
        minutes = here.times_s / SECONDS_PER_MINUTE
        minutes = minutes - minutes.mean()
        products = minutes * here.ratings
        slope = float(products.sum() / (minutes @ minutes))
        return slope if abs(products.sum()) > ROUNDING * np.abs(products).sum() else 0.0

    def time_to(
        self, threshold: float, *, in_a_row: int = 1, ended_s: float | None = None
    ) -> Reached | None:
        """Return when ratings were first at `threshold` or above.

        Parameters
        ----------
        in_a_row
            Successive answered ratings that have to be so high; the time is that of the last of
            them. Missed ratings between them do not count, as in a protocol's stop rule.
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
        above = np.concatenate([[0], np.cumsum(here.ratings >= threshold)])
        ends = np.flatnonzero(above[in_a_row:] - above[:-in_a_row] == in_a_row)
        if ends.size:
            return Reached(float(here.times_s[ends[0] + in_a_row - 1]), reached=True)
        return Reached(float(self.times_s[-1] if ended_s is None else ended_s), reached=False)

    def carried_forward(self, at_s: ArrayLike, *, until_s: float | None = None) -> Floats:
        """Return the last rating answered at or before each time.

        NaN where there was none yet, and in gaps.

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
        for begin_s, end_s in self.gaps_s:
            known &= (at <= begin_s) | (at >= end_s)
        values = np.full(at.shape, np.nan)
        values[known] = here.ratings[place[known]]
        return values


# Symptoms that build up fast and slowly: a model of courses of ratings, fitted to one person.
#
# After Oman (1990) with the constants of Irmak et al. (2022). A constant stimulus that begins at
# 0 passes two second-order lags, a fast one, f, and a slow one, s; each has the step response 1 −
# (1 + t/τ) exp(−t/τ). The slow path makes the fast one more sensitive, and a power law makes a
# rating of it:
#
#     rating(t) = a · (f(t) · (1 + h · s(t)))^n
#
# ``a`` is the rating that the fast path alone would tend to: one for each condition. ``h``, one
# for each person, is how much more sensitive the slow path makes the person in the end. The time
# constants and the power are given: a course of some minutes does not tell them from ``h``.


MOST_SENSITISED = 1000.0
"""Largest ``h`` that is looked for."""
# At 1, an AR(1) process has no stationary variance.
MOST_CORRELATED = 0.99
EDGE = 1e-6
"""An ``h`` below this is 0: its error is not that of a free parameter."""


@dataclass(frozen=True)
class Constants:
    """Time constants and power, those of Irmak et al. (2022) unless others are given."""

    fast_s: float = 66.2
    slow_s: float = 502.0
    exponent: float = 0.4


class Parameter(NamedTuple):
    """An estimate with its interval; None where there is none."""

    estimate: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class SymptomFit:
    """The model of one person."""

    n: int
    """Ratings."""
    levels: dict[str, Parameter]
    """Condition → ``a``, in points of the scale; conditions without any symptom are not here."""
    without_symptoms: tuple[str, ...]
    """Conditions in which every rating was 0: their ``a`` is 0."""
    sensitisation: Parameter
    """``h``; without an interval where it is at 0 or at its largest."""
    residual_sd: float
    r_squared: float
    """Share of the squares about the mean; negative where the mean fits better."""
    autocorrelation: float
    """Of successive residuals; errors are widened for it."""


def lag_step(times_s: ArrayLike, constant_s: float) -> Floats:
    """Return the response of a second-order lag to a step at 0; 0 before it."""
    x = np.maximum(np.asarray(times_s, dtype=np.float64), 0.0) / constant_s
    response: Floats = -np.expm1(-x) - x * np.exp(-x)
    return response


def symptom_course(
    times_s: ArrayLike, level: float, sensitisation: float, constants: Constants | None = None
) -> Floats:
    """Return the ratings that the model expects at times since the start of an exposure."""
    used = constants or Constants()
    return np.asarray(level * _shape(np.asarray(times_s), sensitisation, used)[0])


def _shape(times: Floats, h: float, constants: Constants) -> tuple[Floats, Floats]:
    """Return (f (1 + h s))^n, and its derivative in h over itself."""
    fast, slow = lag_step(times, constants.fast_s), lag_step(times, constants.slow_s)
    grown = 1 + h * slow
    return (fast * grown) ** constants.exponent, constants.exponent * slow / grown


def fit_symptoms(
    courses: Sequence[tuple[str, RatingCourse]],
    constants: Constants | None = None,
    confidence: float = 0.95,
) -> SymptomFit:
    """Fit the model to the courses of one person, by least squares.

    Errors are those of the linearised fit, times (1 + ρ) / (1 − ρ) for residuals of which
    successive ones correlate by ρ.

    Parameters
    ----------
    courses
        The condition of each course, and the course.

    Raises
    ------
    InputError
        If no rating is above 0, or there are too few ratings for the parameters.
    """
    used = constants or Constants()
    answered = [(name, course.answered) for name, course in courses]
    answered = [(name, course) for name, course in answered if course.ratings.size]
    ill = dict.fromkeys(name for name, c in answered if c.ratings.max() > 0)
    well = dict.fromkeys(name for name, _ in answered if name not in ill)
    if not ill:
        raise InputError("no rating was above 0, so there is no course to model")
    data = _Data.of([(name, c) for name, c in answered if name in ill], list(ill))
    if data.ratings.size < len(ill) + 2:
        raise InputError(f"{data.ratings.size} ratings are too few for {len(ill) + 1} parameters")
    best = min((data.fit(used, start) for start in (0.5, 10.0)), key=lambda found: found.cost)
    return _result(best, data, used, tuple(well), confidence)


@dataclass(frozen=True)
class _Data:
    names: list[str]
    times: Floats
    ratings: Floats
    condition: NDArray[np.int64]
    course: NDArray[np.int64]

    @classmethod
    def of(cls, courses: list[tuple[str, RatingCourse]], names: list[str]) -> _Data:
        sizes = [c.ratings.size for _, c in courses]
        return cls(
            names,
            np.concatenate([c.times_s for _, c in courses]),
            np.concatenate([c.ratings for _, c in courses]),
            np.repeat([names.index(name) for name, _ in courses], sizes),
            np.repeat(np.arange(len(courses)), sizes),
        )

    def expected(self, parameters: Floats, used: Constants) -> Floats:
        shape, _ = _shape(self.times, float(parameters[-1]), used)
        expected: Floats = np.exp(parameters[:-1])[self.condition] * shape
        return expected

    def jacobian(self, parameters: Floats, used: Constants) -> Floats:
        expected = self.expected(parameters, used)
        table = np.zeros((expected.size, parameters.size))
        table[np.arange(expected.size), self.condition] = expected
        table[:, -1] = expected * _shape(self.times, float(parameters[-1]), used)[1]
        return table

    def fit(self, used: Constants, start: float) -> _Found:
        highest = [self.ratings[self.condition == c].max() for c in range(len(self.names))]
        first = np.array([*np.log(highest), start])
        low = np.array([*np.full(len(self.names), -30.0), 0.0])
        high = np.array([*np.full(len(self.names), 30.0), MOST_SENSITISED])
        found = least_squares(
            lambda p: self.expected(p, used) - self.ratings,
            first,
            jac=lambda p: self.jacobian(p, used),
            bounds=(low, high),
            x_scale=np.array([*np.ones(len(self.names)), 1.0 + start]),
            ftol=1e-12,
            xtol=1e-12,
            gtol=1e-12,
            max_nfev=500,
        )
        return _Found(np.asarray(found.x), np.asarray(found.fun), float(found.cost))


class _Found(NamedTuple):
    parameters: Floats
    residuals: Floats
    cost: float


def _result(
    found: _Found, data: _Data, used: Constants, well: tuple[str, ...], confidence: float
) -> SymptomFit:
    parameters = found.parameters.copy()
    h = float(parameters[-1])
    free = np.ones(parameters.size, dtype=bool)
    free[-1] = EDGE < h < MOST_SENSITISED * (1 - EDGE)
    df = data.ratings.size - int(free.sum())
    squares = float(found.residuals @ found.residuals)
    rho = _autocorrelation(found.residuals, data.course, parameters.size)
    table = data.jacobian(parameters, used)[:, free]
    variance = squares / df * (1 + rho) / (1 - rho)
    covariance = variance * np.linalg.pinv(table.T @ table, hermitian=True)
    half = np.full(parameters.size, np.nan)
    half[free] = t_distribution.isf((1 - confidence) / 2, df) * np.sqrt(np.diag(covariance))
    about = data.ratings - data.ratings.mean()
    total = float(about @ about)
    sensitised = Parameter(h if h > EDGE else 0.0, None, None)
    if free[-1]:
        sensitised = Parameter(h, max(h - float(half[-1]), 0.0), h + float(half[-1]))
    return SymptomFit(
        n=data.ratings.size,
        levels={
            name: Parameter(float(np.exp(log)), _exp(log - wide), _exp(log + wide))
            for name, log, wide in zip(data.names, parameters[:-1], half[:-1], strict=True)
        },
        without_symptoms=well,
        sensitisation=sensitised,
        residual_sd=float(np.sqrt(squares / df)),
        r_squared=1 - squares / total if total > 0 else float("nan"),
        autocorrelation=rho,
    )


def _exp(value: float) -> float | None:
    return float(np.exp(value)) if value < 50 else None


def _autocorrelation(residuals: Floats, course: NDArray[np.int64], parameters: int) -> float:
    """Return the correlation of residuals that follow each other in a course, from 0.

    Residuals of a smooth curve with p parameters correlate by (p + (p + 2) ρ) / n less than what
    they are residuals of; that is put back.
    """
    together = course[1:] == course[:-1]
    squares, n = float(residuals @ residuals), residuals.size
    if squares <= 0 or not together.any() or n <= parameters + 3:
        return 0.0
    seen = float(np.sum(residuals[1:][together] * residuals[:-1][together])) / squares
    rho = (seen + parameters / n) / (1 - (parameters + 2) / n)
    return min(max(rho, 0.0), MOST_CORRELATED)
