"""Time to an event: Kaplan-Meier curves, log-rank tests, proportional hazards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2, norm

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]

# Time to an event where not everybody has it: Kaplan–Meier curves and log-rank tests.
#
# Own code because lifelines 0.30 asks for pandas < 3 and has neither R's default interval nor
# observed and expected counts. The tests hold all of it to R's ``survival`` (Therneau 2023).


TIED = 1e-9
"""Times that differ by less than this share are one time: sums of seconds are not exact."""


@dataclass(frozen=True)
class SurvivalAt:
    """A Kaplan–Meier curve at one time."""

    time_s: float
    at_risk: int
    """Observed until just before that time or longer."""
    events: int
    """Since the time listed before, that one excluded, this one included."""
    survival: float
    standard_error: float | None
    """Of `survival`; None where it is 0: Greenwood's formula has no value there."""
    low: float | None
    high: float | None


@dataclass(frozen=True)
class KaplanMeier:
    """A Kaplan–Meier curve: a row for each different time of an event or a censoring."""

    times_s: Floats
    at_risk: Integers
    events: Integers
    survival: Floats
    standard_errors: Floats
    """Of `survival`: Greenwood's, or robust to repeated people; NaN where `survival` is 0."""
    low: Floats
    high: Floats
    confidence: float
    robust: bool

    @property
    def n(self) -> int:
        """Return the number of courses."""
        return int(self.at_risk[0])

    def at(self, times_s: ArrayLike) -> list[SurvivalAt]:
        """Return the curve at ascending times; nothing for times after the last observed one."""
        found, before = [], 0
        for time in np.asarray(times_s, dtype=np.float64):
            if time > self.times_s[-1]:
                break
            row = int(np.searchsorted(self.times_s, time, side="right"))
            at_risk = int(self.at_risk[np.searchsorted(self.times_s, time)])
            events, before = int(self.events[before:row].sum()), row
            if row == 0:
                found.append(SurvivalAt(float(time), at_risk, 0, 1.0, 0.0, None, None))
                continue
            numbers = (self.standard_errors, self.low, self.high)
            error, low, high = (_known(values[row - 1]) for values in numbers)
            survival = float(self.survival[row - 1])
            found.append(SurvivalAt(float(time), at_risk, events, survival, error, low, high))
        return found

    def median_s(self) -> tuple[float | None, float | None, float | None]:
        """Return the time at which half had the event, with its interval (Brookmeyer & Crowley).

        None: the curve, or a bound of its interval, never falls to a half. Where it stays at a half
        exactly, the middle of that stretch, as R has it.
        """
        estimate, low, high = (
            self._first_at_half(values) for values in (self.survival, self.low, self.high)
        )
        return estimate, low, high

    def _first_at_half(self, values: Floats) -> float | None:
        below = np.flatnonzero(values <= 0.5 + 1e-8)
        if not below.size:
            return None
        first = int(below[0])
        further = np.flatnonzero(values < 0.5 - 1e-8)
        if abs(values[first] - 0.5) <= 1e-8 and further.size:
            return float(self.times_s[first] + self.times_s[further[0]]) / 2
        return float(self.times_s[first])


def _known(value: float) -> float | None:
    return None if np.isnan(value) else float(value)


def kaplan_meier(
    times_s: ArrayLike,
    events: ArrayLike,
    *,
    people: ArrayLike | None = None,
    confidence: float = 0.95,
) -> KaplanMeier:
    """Estimate how many have not had the event by each time.

    The interval is that of log(−log survival) (``conf.type = "log-log"`` in R), which stays between
    0 and 1 and covers with few courses, where R's default, of log survival, does not (.94 and .84
    of 8; Borgan & Liestøl 1990). Where survival is 0 or 1 there is none.

    Parameters
    ----------
    times_s
        When the event came or the watching ended, shape (n,), not negative.
    events
        1 (or True) where the event came, 0 where it was censored.
    people
        Who each course is of, shape (n,). With it, standard errors are those of the infinitesimal
        jackknife over people, whose courses are not independent; without it, Greenwood's.

    Raises
    ------
    InputError
        If there is no course, or a time is missing or negative.
    """
    times, had = _checked(times_s, events)
    moments, place = np.unique(times, return_inverse=True)
    deaths = np.bincount(place, had).astype(np.int64)
    at_risk = times.size - np.searchsorted(np.sort(times), moments)
    with np.errstate(divide="ignore", invalid="ignore"):
        survival = np.cumprod(1 - deaths / at_risk, dtype=np.float64)
        if people is None:
            variance = np.cumsum(deaths / (at_risk * (at_risk - deaths)))
        else:
            variance = _jackknife_variance(place, had, deaths, at_risk, np.asarray(people))
    errors: Floats = np.sqrt(np.where(survival > 0, variance, np.nan))
    inside = np.where((survival > 0) & (survival < 1), survival, np.nan)
    half = norm.isf((1 - confidence) / 2) * errors / -np.log(inside)
    return KaplanMeier(
        times_s=moments,
        at_risk=at_risk.astype(np.int64),
        events=deaths,
        survival=survival,
        standard_errors=survival * errors,
        low=inside ** np.exp(half),
        high=inside ** np.exp(-half),
        confidence=confidence,
        robust=people is not None,
    )


def _jackknife_variance(
    place: Integers, had: Floats, deaths: Integers, at_risk: Integers, people: NDArray[np.generic]
) -> Floats:
    """Return the variance of log S at each time: squared influences, summed within people first.

    The influence of a course on log S(t) is −Σ (dN − h Y) / (n (1 − h)) over the times until t,
    with h the share of those at risk who have the event (Therneau 2023, section 2.2).
    """
    left = np.maximum(at_risk - deaths, 1)  # where nobody is left, survival is 0 and has no error
    stay = np.cumsum(deaths / (at_risk * left))
    who = np.unique(people, return_inverse=True)[1].ravel()
    variance = np.zeros(deaths.size)
    for person in range(who.max() + 1):
        influence = np.zeros(deaths.size)
        for course in np.flatnonzero(who == person):
            last = place[course]
            influence += np.where(np.arange(deaths.size) < last, stay, stay[last])
            if had[course]:
                influence[last:] -= 1 / left[last]
        variance += influence**2
    return variance


@dataclass(frozen=True)
class LogRank:
    """A log-rank test of several groups."""

    groups: tuple[str, ...]
    n: tuple[int, ...]
    observed: tuple[int, ...]
    expected: tuple[float, ...]
    """Events that each group would have had if all were alike."""
    chi_square: float
    df: int
    p: float
    """The exact p, or that of χ² without one."""
    p_exact: float | None
    """Of two groups: over all ways in which labels could have fallen within strata; None of more
    groups, and where that are more sums than `MOST_SUMS`."""
    p_asymptotic: float
    strata: int
    """Within how many strata courses were compared; 1: all with all."""


def log_rank(
    times_s: ArrayLike,
    events: ArrayLike,
    groups: ArrayLike,
    *,
    strata: ArrayLike | None = None,
) -> LogRank:
    """Test whether groups differ in the time to an event.

    Observed minus expected events of a group are the sum of its courses' scores, 1 (if the event
    came) minus the cumulative hazard at their end; the exact test permutes labels within strata
    (Cox & Oakes 1984, section 7.4), which takes censoring to be alike under both labels.

    Parameters
    ----------
    groups
        Name of each course's group, shape (n,).
    strata
        Courses are compared within these alone, as with participants who met several conditions.

    Raises
    ------
    InputError
        If there are fewer than two groups, no event, or nothing to compare within strata.
    """
    times, had = _checked(times_s, events)
    names, member = np.unique(np.asarray(groups, dtype=str), return_inverse=True)
    layers = np.zeros(times.size, dtype=np.int64)
    if strata is not None:
        layers = np.unique(np.asarray(strata), return_inverse=True)[1].ravel()
    if names.size < 2:
        raise InputError("there is one group only, so nothing is compared")
    if not had.any():
        raise InputError("there were no events, so times are not compared")
    expected, covariance = np.zeros(names.size), np.zeros((names.size, names.size))
    for layer in range(layers.max() + 1):
        here = layers == layer
        more, spread = _of_stratum(times[here], had[here], member[here], names.size)
        expected, covariance = expected + more, covariance + spread
    observed = np.bincount(member, had, names.size)
    compared = np.diag(covariance) > 0
    if compared.sum() < 2:
        raise InputError("no event came while both groups were observed, so nothing is compared")
    difference = (observed - expected)[compared][1:]
    part = covariance[np.ix_(compared, compared)][1:, 1:]
    statistic = float(difference @ np.linalg.pinv(part, hermitian=True) @ difference)
    df = int(np.linalg.matrix_rank(part, hermitian=True))
    asymptotic = float(chi2.sf(statistic, df))
    exact = None
    if names.size == 2:
        strata_of = [np.flatnonzero(layers == layer) for layer in range(layers.max() + 1)]
        exact = _permutation_p(
            [(_scores(times[rows], had[rows]), member[rows] == 1) for rows in strata_of]
        )
    return LogRank(
        groups=tuple(map(str, names)),
        n=tuple(map(int, np.bincount(member))),
        observed=tuple(map(int, observed)),
        expected=tuple(map(float, expected)),
        chi_square=statistic,
        df=df,
        p=asymptotic if exact is None else exact,
        p_exact=exact,
        p_asymptotic=asymptotic,
        strata=int(layers.max()) + 1,
    )


MOST_SUMS = 50_000
"""Different sums up to which their exact distribution is made."""
_DIGITS = 12
"""Of sums of scores that are kept apart."""
_ONE_SUM = 1e-8
"""Sums that differ by less are one: each is of a few hundred rounded scores at most."""


def _scores(times: Floats, had: Floats) -> Floats:
    """Return the log-rank score of each course: observed minus expected events until its end."""
    moments, place = np.unique(times, return_inverse=True)
    at_risk = times.size - np.searchsorted(np.sort(times), moments)
    hazard = np.cumsum(np.bincount(place, had) / at_risk)
    scores: Floats = had - hazard[place]
    return scores


def _permutation_p(strata: list[tuple[Floats, NDArray[np.bool_]]]) -> float | None:
    """Return the share of labellings within strata with a sum at least as far from 0."""
    sums, shares = np.zeros(1), np.ones(1)
    for scores, mine in strata:
        if mine.all() or not mine.any():
            continue
        own = _sums_of(scores, int(mine.sum()))
        if own is None or sums.size * own[0].size > MOST_SUMS * 20:
            return None
        sums, shares = _merged(
            np.add.outer(sums, own[0]).ravel(), np.multiply.outer(shares, own[1]).ravel()
        )
        if sums.size > MOST_SUMS:
            return None
    observed = sum(float(scores[mine].sum()) for scores, mine in strata if not mine.all())
    far = np.abs(sums) >= abs(observed) - _ONE_SUM
    return min(1.0, float(shares[far].sum()))


def _sums_of(scores: Floats, count: int) -> tuple[Floats, Floats] | None:
    """Return the sums of `count` of the scores, and the share of subsets with each."""
    of_size: list[tuple[Floats, Floats]] = [(np.zeros(1), np.ones(1))]
    for done, score in enumerate(scores):
        longest = min(done + 1, count)
        grown = [of_size[0]]
        for size in range(1, longest + 1):
            values, ways = of_size[size - 1]
            values = values + score
            if size < len(of_size):
                values = np.concatenate([of_size[size][0], values])
                ways = np.concatenate([of_size[size][1], ways])
            grown.append(_merged(values, ways))
            if grown[-1][0].size > MOST_SUMS:
                return None
        of_size = grown
    sums, ways = of_size[count]
    return sums, ways / ways.sum()


def _merged(sums: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Return the different sums, with their weights added."""
    found, place = np.unique(np.round(sums, _DIGITS), return_inverse=True)
    return found, np.bincount(place, weights).astype(np.float64)


def _of_stratum(times: Floats, had: Floats, member: Integers, groups: int) -> tuple[Floats, Floats]:
    """Return the expected events of each group, and the covariance of observed minus expected."""
    expected, covariance = np.zeros(groups), np.zeros((groups, groups))
    for moment in np.unique(times[had > 0]):
        at_risk = np.bincount(member[times >= moment], minlength=groups)
        total, deaths = at_risk.sum(), had[times == moment].sum()
        share = at_risk / total
        expected += deaths * share
        if total > 1:
            left = deaths * (total - deaths) / (total - 1)
            covariance += left * (np.diag(share) - np.outer(share, share))
    return expected, covariance


def _checked(times_s: ArrayLike, events: ArrayLike) -> tuple[Floats, Floats]:
    """Return times, those that differ by rounding made equal, and events as 0 and 1."""
    times = np.asarray(times_s, dtype=np.float64)
    had = np.asarray(events, dtype=np.float64)
    if times.ndim != 1 or times.shape != had.shape:
        raise InputError("times and events need one value for each course")
    if not times.size:
        raise InputError("there is no course to look at")
    if not (np.isfinite(times).all() and (times >= 0).all()):
        raise InputError("a time to an event is missing, infinite or negative; give seconds")
    if not np.isin(had, (0, 1)).all():
        raise InputError("an event is neither 0 (censored) nor 1 (it came)")
    return one_time(times), had


def one_time(times: Floats) -> Floats:
    """Return times in which those that differ by rounding alone are equal."""
    order = np.argsort(times)
    ascending = times[order]
    step = np.diff(ascending, prepend=-np.inf) > TIED * max(float(ascending[-1]), 1.0)
    result = np.empty_like(times)
    result[order] = ascending[np.maximum.accumulate(np.where(step, np.arange(times.size), 0))]
    return result


# Cox's proportional hazards: how often an event comes under one condition for once under another.
#
# Ties are Efron's. Errors are robust to people who come more than once (Lin & Wei 1989). The
# tests hold all of it to R's ``coxph``.


MOST_STEPS = 50
CONVERGED = 1e-12
"""Newton's decrement, relative to the log likelihood, at which the search ends."""
UNBOUNDED = 100.0
"""Standard error × SD of a covariate from which on the likelihood is flat: it has no maximum."""


@dataclass(frozen=True)
class HazardRatio:
    """One effect: the ratio of hazards per unit of a covariate."""

    ratio: float
    low: float
    high: float
    coefficient: float
    """Its natural logarithm."""
    standard_error: float
    """Of the coefficient, by the likelihood alone."""
    robust_error: float | None
    """Of the coefficient, robust to repeated people; None where everybody came once."""
    z: float
    """Over the robust error where there is one, as are p and the interval."""
    p: float


@dataclass(frozen=True)
class Cox:
    """A fitted model."""

    n: int
    events: int
    people: int
    effects: dict[str, HazardRatio]
    log_likelihood: float
    likelihood_ratio: float
    """2 × the gain in log likelihood over no effect; it ignores that people repeat."""
    wald: float
    """Of all effects together, with the errors that are printed."""
    df: int
    p: float
    """Of `wald`."""


NO_ERROR = 1e-9
"""Share of a coefficient's own standard error below which the robust one is rounding."""


@dataclass(frozen=True)
class _Risk:
    """The risk set at one time of events: Efron's denominators."""

    dying: Integers
    at_risk: Integers
    shares: Floats
    """k/d for k = 0 … d − 1: how much of the dying is out of each denominator."""


class NoHazardRatioError(InputError):
    """A hazard ratio that grows, or falls, without end.

    Parameters
    ----------
    term
        Name of its column.
    """

    def __init__(self, term: str) -> None:
        self.term = term
        side = "all events, or none, lie on one side of it"
        super().__init__(f"the hazard ratio of {term} has no estimate: {side}")


def cox(
    times_s: ArrayLike,
    events: ArrayLike,
    covariates: Mapping[str, ArrayLike],
    *,
    people: ArrayLike | None = None,
    confidence: float = 0.95,
) -> Cox:
    """Fit hazards that are proportional over time.

    Parameters
    ----------
    times_s, events
        As in `kaplan_meier`.
    covariates
        Name → values, shape (n,).
    people
        Who each course is of, shape (n,). Where somebody comes twice, standard errors, intervals
        and p are robust: scores are summed within people.

    Raises
    ------
    InputError
        If there is no event, a covariate says nothing of its own, no robust error is left, or the
        hazard ratio is 0 or infinite because all events, or none, lie on one side of it.
    """
    times = one_time(np.asarray(times_s, dtype=np.float64))
    had = np.asarray(events, dtype=np.float64) > 0
    names = list(covariates)
    raw = np.column_stack([np.asarray(covariates[name], dtype=np.float64) for name in names])
    design = raw - raw.mean(axis=0)
    if not had.any():
        raise InputError("there were no events, so hazards are not compared")
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise InputError(f"{' and '.join(names)} cannot be told apart in these data")
    risks = _risk_sets(times, had)
    fit = _maximise(design, risks, names)
    likelihood, information = fit[1], fit[2]
    coefficients = fit[0]
    naive = np.linalg.inv(information)
    who = np.arange(times.size) if people is None else np.unique(people, return_inverse=True)[1]
    repeated = int(who.max()) + 1 < times.size
    covariance = naive
    if repeated:
        scores = _score_residuals(design, coefficients, risks)
        totals = np.stack([np.bincount(who, column) for column in scores.T], axis=1)
        covariance = naive @ (totals.T @ totals) @ naive
    wald = float(coefficients @ np.linalg.pinv(covariance, hermitian=True) @ coefficients)
    half = float(norm.isf((1 - confidence) / 2))
    errors, plain = np.sqrt(np.diag(covariance)), np.sqrt(np.diag(naive))
    if (errors <= NO_ERROR * plain).any():
        raise InputError("the people are too few, or too alike, for robust errors")
    return Cox(
        n=times.size,
        events=int(had.sum()),
        people=int(who.max()) + 1,
        effects={
            name: _effect(float(beta), float(one), float(two) if repeated else None, half)
            for name, beta, one, two in zip(names, coefficients, plain, errors, strict=True)
        },
        log_likelihood=likelihood,
        likelihood_ratio=2 * (likelihood - _likelihood(design, np.zeros(len(names)), risks)[0]),
        wald=wald,
        df=len(names),
        p=float(chi2.sf(wald, len(names))),
    )


def _effect(beta: float, plain: float, robust: float | None, half: float) -> HazardRatio:
    error = plain if robust is None else robust
    z = beta / error
    return HazardRatio(
        ratio=float(np.exp(beta)),
        low=float(np.exp(beta - half * error)),
        high=float(np.exp(beta + half * error)),
        coefficient=beta,
        standard_error=plain,
        robust_error=robust,
        z=z,
        p=float(2 * norm.sf(abs(z))),
    )


def _risk_sets(times: Floats, had: NDArray[np.bool_]) -> list[_Risk]:
    found = []
    for moment in np.unique(times[had]):
        dying = np.flatnonzero((times == moment) & had)
        shares = np.arange(dying.size) / dying.size
        found.append(_Risk(dying, np.flatnonzero(times >= moment), shares))
    return found


def _maximise(design: Floats, risks: list[_Risk], names: list[str]) -> tuple[Floats, float, Floats]:
    """Return coefficients, log likelihood and information, by Newton's method with halved steps."""
    beta = np.zeros(design.shape[1])
    value, score, information = _likelihood(design, beta, risks)
    spread = design.std(axis=0)
    for _ in range(MOST_STEPS):
        step = np.linalg.lstsq(information, score, rcond=None)[0]
        gain = float(step @ score)
        while True:
            there = _likelihood(design, beta + step, risks)
            if there[0] >= value or np.abs(step).max() < CONVERGED:
                break
            step = step / 2
        beta = beta + step
        value, score, information = there
        if np.linalg.matrix_rank(information, hermitian=True) < beta.size or np.any(
            np.sqrt(np.diag(np.linalg.inv(information))) * spread > UNBOUNDED
        ):
            break
        if abs(gain) <= CONVERGED * max(abs(value), 1.0):
            return beta, value, information
    worst = names[int(np.argmax(np.abs(beta) * spread))]
    raise NoHazardRatioError(worst)


def _likelihood(design: Floats, beta: Floats, risks: list[_Risk]) -> tuple[float, Floats, Floats]:
    """Return Efron's log partial likelihood, its gradient and minus its second derivative."""
    linear = design @ beta
    weights = np.exp(linear - linear.max())
    value, p = 0.0, beta.size
    score, information = np.zeros(p), np.zeros((p, p))
    for risk in risks:
        totals, means, second = _moments(design, weights, risk)
        value += float(linear[risk.dying].sum() - np.log(totals).sum())
        value -= float(linear.max()) * risk.dying.size
        score += design[risk.dying].sum(axis=0) - means.sum(axis=0)
        information += second - means.T @ means
    return value, score, information


def _moments(design: Floats, weights: Floats, risk: _Risk) -> tuple[Floats, Floats, Floats]:
    """Return each denominator, shape (d,), its mean covariates (d, p), and the sum of squares."""
    x, w = design[risk.at_risk], weights[risk.at_risk]
    dx, dw = design[risk.dying], weights[risk.dying]
    totals = w.sum() - risk.shares * dw.sum()
    means = ((w @ x)[None, :] - risk.shares[:, None] * (dw @ dx)) / totals[:, None]
    second = (x * w[:, None]).T @ x * np.sum(1 / totals)
    second = second - (dx * dw[:, None]).T @ dx * np.sum(risk.shares / totals)
    return totals, means, second


def _score_residuals(design: Floats, beta: Floats, risks: list[_Risk]) -> Floats:
    """Return each course's score residual, shape (n, p), as R's ``coxph`` with Efron ties."""
    linear = design @ beta
    weights = np.exp(linear - linear.max())
    residuals = np.zeros_like(design)
    for risk in risks:
        totals, means, _ = _moments(design, weights, risk)
        out = np.zeros(design.shape[0])
        out[risk.dying] = 1.0
        residuals[risk.dying] += design[risk.dying] - means.mean(axis=0)
        for total, mean, share in zip(totals, means, risk.shares, strict=True):
            here = risk.at_risk
            hazard = weights[here] * (1 - share * out[here]) / total
            residuals[here] -= hazard[:, None] * (design[here] - mean)
    return residuals
