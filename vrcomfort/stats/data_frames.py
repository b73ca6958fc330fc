"""Tests and models of tidy data frames: frames in, frames out, as in pingouin.

Data frames are long: one row for each participant and cell, with the value in column `dv`. Columns
are named by `within`, `between` and `subject` as in pingouin. A result has one row for each test or
effect; `low` and `high` are its interval. Numbers are those of a report of the same data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.stats import anova as _anova
from vrcomfort.stats import correlation as _correlation
from vrcomfort.stats import mann_whitney as _mann_whitney
from vrcomfort.stats import mixed as _mixed
from vrcomfort.stats import multiplicity as _multiplicity
from vrcomfort.stats import ordinal as _ordinal
from vrcomfort.stats import rank_anova as _rank_anova
from vrcomfort.stats import signed_rank as _signed_rank
from vrcomfort.stats import survival as _survival
from vrcomfort.stats import t_tests as _t_tests
from vrcomfort.stats.columns import with_columns
from vrcomfort.stats.ranks import as_integers

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vrcomfort.stats.anova import AnovaEffect, SumsOfSquares
    from vrcomfort.stats.correlation import Method
    from vrcomfort.stats.effects import EffectSize
    from vrcomfort.stats.mixed import Errors, Estimate
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.shift import Shift
    from vrcomfort.stats.signed_rank import PValue, Zeros
    from vrcomfort.stats.t_tests import Variances

Row = dict[str, Any]
"""Column → cell of a line of a result."""
STEPS = (1.0, 0.1, 0.01, 0.001)
"""Steps of a scale that are tried where none is given: ranks need exact ties, and sums of weighted
answers (3.74, 9.54 …) are whole numbers of hundredths."""


@with_columns
def wilcoxon(
    data: pd.DataFrame,
    *,
    dv: str,
    within: str,
    subject: str,
    alternative: Alternative = "two-sided",
    zeros: Zeros = "pratt",
    p_value: PValue = "exact",
    unit: float | None = None,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Test paired differences by Wilcoxon's signed ranks, exact with ties.

    Parameters
    ----------
    data : pandas.DataFrame
        Long data with at most one row for each `subject` and level of `within`.
    dv, within, subject : str
        Columns of the values, the conditions, and the participants.
    alternative : {"two-sided", "greater", "less"}
        ``greater``: `A` tends to be larger than `B`.
    zeros : {"pratt", "wilcox"}
        Zeros are ranked, then dropped; or dropped, then ranked.
    p_value : {"exact", "asymptotic"}
        ``exact``: from the distribution given the ties, up to 500 pairs.
    unit : float, optional
        Step of the scale in points; the largest of 1, 0.1, 0.01, 0.001 that fits, without it.
    confidence : float
        Of the intervals.

    Returns
    -------
    pandas.DataFrame
        A row for each pair of levels: ``A``, ``B``, ``n`` pairs, ``excluded`` (without both
        values), ``zeros``, ``ties``, ``W_plus``, ``W_minus``, ``Z``, ``p``, ``method``,
        ``p_holm`` over the rows, ``shift`` (Hodges-Lehmann, `A` minus `B`, in points) with
        ``low`` and ``high``, and ``rank_biserial`` with ``rb_low`` and ``rb_high``.

    Raises
    ------
    InputError
        If a participant has two values under one level, there are fewer than two levels, or no
        step fits the values.

    Examples
    --------
    >>> data = pd.DataFrame({"who": [1, 2, 3, 4, 5, 6, 7] * 2})
    >>> data["seen"] = ["off"] * 7 + ["on"] * 7
    >>> data["total"] = [9, 6, 7, 9, 5, 8, 10, 6, 5, 7, 7, 6, 4, 8]
    >>> test = wilcoxon(data, dv="total", within="seen", subject="who")
    >>> test[["A", "B", "n", "W_plus", "p", "shift"]].values.tolist()[0]
    ['off', 'on', 7, 24.5, 0.09375, 1.5]
    """
    table = _paired(data, dv, within, subject)
    step = _step(table.to_numpy(), unit)

    def compare(a: Any, b: Any) -> Row:
        both = table[[a, b]].dropna()
        first, second = (as_integers(both[each], step) for each in (a, b))
        test = _signed_rank.signed_rank(
            first - second, step, zeros=zeros, alternative=alternative, p_value=p_value,
            confidence=confidence,
        )  # fmt: skip
        return {
            "n": test.n, "excluded": len(table) - test.n, "zeros": test.zeros,
            "ties": test.ties, "W_plus": test.w_plus, "W_minus": test.w_minus, "Z": test.z,
            "p": test.p, "method": test.method,
            **_estimate(test.shift, "shift"), **_estimate(test.effect, "rank_biserial", "rb_"),
        }  # fmt: skip

    return _each_pair(table.columns, within, compare)


@with_columns
def mwu(
    data: pd.DataFrame,
    *,
    dv: str,
    between: str,
    alternative: Alternative = "two-sided",
    p_value: PValue = "exact",
    unit: float | None = None,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Test two groups of different people by the Mann-Whitney test, exact with ties.

    Parameters
    ----------
    data : pandas.DataFrame
        One row for each person.
    dv, between : str
        Columns of the values and the groups.
    alternative, p_value, unit, confidence
        As in `wilcoxon`; exact up to 100 people.

    Returns
    -------
    pandas.DataFrame
        A row for each pair of groups: ``A``, ``B``, ``n_A``, ``n_B``, ``ties``, ``U``, ``Z``,
        ``p``, ``method``, ``p_holm``, ``shift`` (Hodges-Lehmann, in points) with ``low`` and
        ``high``, and ``rank_biserial`` with ``rb_low`` and ``rb_high``.

    Raises
    ------
    InputError
        If there are fewer than two groups, or no step fits the values.
    """
    groups = _groups(data, dv, between)
    step = _step(np.concatenate(list(groups.values())), unit)

    def compare(a: Any, b: Any) -> Row:
        first, second = (as_integers(groups[each], step) for each in (a, b))
        test = _mann_whitney.mann_whitney(
            first, second, step, alternative=alternative, p_value=p_value, confidence=confidence
        )
        assert test is not None  # noqa: S101 - every group has a value
        return {
            "n_A": test.n_a, "n_B": test.n_b, "ties": test.ties, "U": test.u,
            "Z": test.z, "p": test.p, "method": test.method,
            **_estimate(test.shift, "shift"), **_estimate(test.effect, "rank_biserial", "rb_"),
        }  # fmt: skip

    return _each_pair(groups, between, compare)


@with_columns
def ttest(
    data: pd.DataFrame,
    *,
    dv: str,
    within: str | None = None,
    between: str | None = None,
    subject: str | None = None,
    alternative: Alternative = "two-sided",
    variances: Variances = "welch",
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Compare means by t tests, of pairs (`within`, `subject`) or of groups (`between`).

    Parameters
    ----------
    data : pandas.DataFrame
        Long data with at most one row for each participant and level.
    dv, within, between, subject : str
        Columns; either `within` and `subject`, or `between`.
    alternative : {"two-sided", "greater", "less"}
        ``greater``: the mean of `A` is larger than that of `B`.
    variances : {"welch", "pooled"}
        Of groups: each has its own, or both share one.
    confidence : float
        Of the intervals.

    Returns
    -------
    pandas.DataFrame
        A row for each pair of levels: ``A``, ``B``, ``n``, ``mean`` difference, ``se``, ``df``,
        ``T``, ``p``, ``p_holm``, ``low``, ``high``, ``hedges_g`` with ``g_low`` and ``g_high``,
        ``BF10`` (JZS). Without a test (missing) where values do not vary.

    Raises
    ------
    InputError
        If the columns name neither design, or there are fewer than two levels.
    """
    if (within is None or subject is None) == (between is None):
        raise InputError("give `within` and `subject` for pairs, or `between` for groups")
    if between is not None:
        groups = _groups(data, dv, between)

        def compare_groups(a: Any, b: Any) -> Row:
            found = _t_tests.two_sample_t(
                groups[a], groups[b], variances=variances, alternative=alternative,
                confidence=confidence,
            )  # fmt: skip
            return _t_row(found)

        return _each_pair(groups, between, compare_groups)
    table = _paired(data, dv, str(within), str(subject))

    def compare(a: Any, b: Any) -> Row:
        both = table[[a, b]].dropna()
        differences = both[a].to_numpy(float) - both[b].to_numpy(float)
        found = _t_tests.paired_t(differences, alternative=alternative, confidence=confidence)
        return _t_row(found)

    return _each_pair(table.columns, str(within), compare)


@with_columns
def friedman(
    data: pd.DataFrame, *, dv: str, within: str, subject: str, unit: float | None = None
) -> pd.DataFrame:
    """Test several conditions by Friedman's ranks, with Kendall's W.

    Parameters
    ----------
    data : pandas.DataFrame
        Long data with at most one row for each `subject` and level of `within`.
    dv, within, subject : str
        Columns.
    unit : float, optional
        As in `wilcoxon`.

    Returns
    -------
    pandas.DataFrame
        One row: ``n`` complete participants, ``excluded``, ``conditions``, ``ties``, ``Q``,
        ``df``, ``p``, ``W``.

    Raises
    ------
    InputError
        If there are fewer than two complete participants or conditions.
    """
    table = _paired(data, dv, within, subject)
    whole = table.dropna()
    step = _step(whole.to_numpy(), unit)
    scores = as_integers(whole.to_numpy(dtype=np.float64), step)
    test = _rank_anova.friedman(scores)
    return pd.DataFrame([{
        "n": test.n, "excluded": len(table) - len(whole), "conditions": test.conditions,
        "ties": test.ties, "Q": test.chi_square, "df": test.df, "p": test.p, "W": test.kendall_w,
    }])  # fmt: skip


@with_columns
def kruskal(
    data: pd.DataFrame,
    *,
    dv: str,
    between: str,
    p_value: PValue = "exact",
    unit: float | None = None,
) -> pd.DataFrame:
    """Test several groups of different people by the Kruskal-Wallis test, exact if small.

    Parameters
    ----------
    data : pandas.DataFrame
        One row for each person.
    dv, between : str
        Columns.
    p_value, unit
        As in `wilcoxon`.

    Returns
    -------
    pandas.DataFrame
        One row: ``groups``, ``n``, ``ties``, ``H``, ``df``, ``p``, ``method``,
        ``epsilon_squared``.

    Raises
    ------
    InputError
        If there are fewer than two groups or three people.
    """
    groups = _groups(data, dv, between)
    step = _step(np.concatenate([*groups.values(), np.empty(0)]), unit)
    test = _rank_anova.kruskal_wallis(
        [as_integers(each, step) for each in groups.values()], p_value=p_value
    )
    return pd.DataFrame([{
        "groups": len(test.sizes), "n": sum(test.sizes), "ties": test.ties, "H": test.h,
        "df": test.df, "p": test.p, "method": test.method,
        "epsilon_squared": test.epsilon_squared,
    }])  # fmt: skip


@with_columns
def rm_anova(
    data: pd.DataFrame,
    *,
    dv: str,
    subject: str,
    within: str | Sequence[str] = (),
    between: str | Sequence[str] = (),
    sums_of_squares: SumsOfSquares = "III",
) -> pd.DataFrame:
    """Analyse the variance of a within, between or mixed design.

    Parameters
    ----------
    data : pandas.DataFrame
        Long data with at most one row for each `subject` and cell.
    dv, subject : str
        Columns of the values and the participants.
    within, between : str or sequence of str
        Factors crossed within participants, and factors that group them.
    sums_of_squares : {"III", "II"}
        They differ where groups differ in size.

    Returns
    -------
    pandas.DataFrame
        A row for each effect: ``effect``, ``SS``, ``df1``, ``df2``, ``F``, ``p``, ``eps_gg``,
        ``p_gg``, ``eps_hf``, ``p_hf``, ``W_mauchly``, ``p_mauchly`` (missing with one degree of
        freedom), ``ges``, ``np2`` with its 90 % interval ``np2_low``, ``np2_high``, ``n``
        complete participants, ``excluded``.

    Raises
    ------
    InputError
        If a participant has two values in a cell, a factor has fewer than two levels, or there
        are too few complete participants.
    """
    found = _anova.anova(
        data, value=dv, participant=subject, within=_names(within), between=_names(between),
        sums_of_squares=sums_of_squares,
    )  # fmt: skip
    return _anova_frame(found.effects, found.n, len(found.excluded))


@with_columns
def art_anova(
    data: pd.DataFrame,
    *,
    dv: str,
    subject: str,
    within: str | Sequence[str] = (),
    between: str | Sequence[str] = (),
    sums_of_squares: SumsOfSquares = "III",
) -> pd.DataFrame:
    """Analyse ordinal values of a factorial design by aligned rank transform.

    Parameters
    ----------
    data, dv, subject, within, between, sums_of_squares
        As in `rm_anova`.

    Returns
    -------
    pandas.DataFrame
        As `rm_anova`; sums of squares and effect sizes are those of aligned ranks.

    Raises
    ------
    InputError
        As `rm_anova`.
    """
    plain, effects = _rank_anova.aligned_ranks(
        data, value=dv, participant=subject, within=_names(within), between=_names(between),
        sums_of_squares=sums_of_squares,
    )  # fmt: skip
    return _anova_frame(effects, plain.n, len(plain.excluded))


@with_columns
def mixed_model(
    data: pd.DataFrame,
    *,
    dv: str,
    subject: str,
    factors: str | Sequence[str],
    covariates: str | Sequence[str] = (),
    references: Mapping[str, str] | None = None,
    errors: Errors = "cluster_robust",
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Fit ``dv ~ factors + covariates + (1 | subject)`` to all rows, complete people or not.

    Parameters
    ----------
    data : pandas.DataFrame
        Long data; rows without a value are left out.
    dv, subject : str
        Columns of the values and the participants.
    factors, covariates : str or sequence of str
        Columns with categories, and with numbers.
    references : dict, optional
        Reference level of a factor; the first in sorted order without it.
    errors : {"cluster_robust", "model"}
        Standard errors: CR2, robust to skew and to unequal people, or those of the model.
    confidence : float
        Of the intervals.

    Returns
    -------
    pandas.DataFrame
        A row for the intercept and each fixed effect: ``term``, ``estimate``, ``se``, ``df``
        (Satterthwaite), ``T``, ``p``, ``low``, ``high``. ``frame.attrs`` has ``omnibus`` (factor
        → F test), ``participant_sd``, ``residual_sd``, ``n_participants`` and ``n_values``.

    Raises
    ------
    InputError
        If too few values or no variance are left, or factors cannot be told apart.
    """
    fit = _mixed.mixed_model(
        data, value=dv, participant=subject, factors=_names(factors),
        references=dict(references or {}), covariates=_names(covariates), errors=errors,
        confidence=confidence,
    )  # fmt: skip
    return _frame(
        _t_rows("term", {"intercept": fit.intercept, **fit.terms}),
        omnibus={name: asdict(each) for name, each in fit.omnibus.items()},
        participant_sd=fit.participant_sd,
        residual_sd=fit.residual_sd,
        n_participants=fit.n_participants,
        n_values=fit.n_values,
    )


@with_columns
def ordinal_model(
    data: pd.DataFrame,
    *,
    dv: str,
    subject: str,
    factors: str | Sequence[str],
    references: Mapping[str, str] | None = None,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Fit proportional odds of ordered answers, with a random intercept if people repeat.

    Parameters
    ----------
    data, dv, subject, factors, references, confidence
        As in `mixed_model`.

    Returns
    -------
    pandas.DataFrame
        A row for each effect: ``term``, ``log_odds``, ``se``, ``Z``, ``p``, ``odds_ratio`` with
        ``low`` and ``high``. ``frame.attrs`` has ``omnibus`` (factor → likelihood-ratio test),
        ``participant_sd``, ``thresholds``, ``log_likelihood``, ``n_participants``, ``n_values``.

    Raises
    ------
    InputError
        If all answers are alike, factors cannot be told apart, or an effect separates the answers.
    """
    fit = _ordinal.ordinal_model(
        data, value=dv, participant=subject, factors=_names(factors),
        references=dict(references or {}), confidence=confidence,
    )  # fmt: skip
    rows = [
        {
            "term": name, "log_odds": each.estimate, "se": each.standard_error, "Z": each.z,
            "p": each.p, "odds_ratio": each.odds_ratio, "low": each.odds_low,
            "high": each.odds_high,
        }
        for name, each in fit.terms.items()
    ]  # fmt: skip
    return _frame(
        rows,
        omnibus={name: asdict(each) for name, each in fit.omnibus.items()},
        participant_sd=fit.participant_sd,
        thresholds=dict(zip(fit.answers, fit.thresholds, strict=False)),
        log_likelihood=fit.log_likelihood,
        n_participants=fit.n_participants,
        n_values=fit.n_values,
    )


@with_columns
def crossover(
    data: pd.DataFrame,
    *,
    dv: str,
    within: str,
    period: str,
    subject: str,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Analyse a two-period crossover: condition, period, and sequence (carry-over).

    Parameters
    ----------
    data : pandas.DataFrame
        Two rows for each `subject`, one of each period; people with one are left out.
    dv, within, period, subject : str
        Columns; `within` has two levels, and `period` sorts in time.
    confidence : float
        Of the intervals.

    Returns
    -------
    pandas.DataFrame
        A row for each effect: ``effect``, ``estimate`` in points (first level minus second,
        second period minus first, sequence second-first minus first-second), ``se``, ``df``,
        ``T``, ``p``, ``low``, ``high``. ``frame.attrs`` has ``n`` by sequence.

    Raises
    ------
    InputError
        If there are not two levels and two periods, or one sequence has no participant.
    """
    scores, shown = (_paired(data, column, period, subject) for column in (dv, within))
    levels = sorted(map(str, data[within].dropna().unique()))
    if len(levels) != 2 or scores.shape[1] != 2:
        raise InputError("a crossover has two conditions and two periods")
    there = scores.notna().all(axis=1) & shown.notna().all(axis=1)
    first, second = (scores.loc[there, each].to_numpy(float) for each in scores.columns)
    a_first = (shown.loc[there].iloc[:, 0].astype(str) == levels[0]).to_numpy()
    found = _mixed.crossover(first, second, a_first, confidence=confidence)
    a, b = levels
    effects = {
        f"{within}: {a} − {b}": found.condition,
        f"{period}: {scores.columns[1]} − {scores.columns[0]}": found.period,
        f"sequence: {b}, {a} − {a}, {b}": found.sequence,
    }
    sizes = {f"{a}, {b}": found.n_ab, f"{b}, {a}": found.n_ba}
    return _frame(_t_rows("effect", effects), n=sizes)


@with_columns
def corr(
    data: pd.DataFrame,
    *,
    x: str,
    y: str,
    subject: str | None = None,
    method: Method = "spearman",
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Correlate two columns: between people, or within people with ``"repeated_measures"``.

    Parameters
    ----------
    data : pandas.DataFrame
        One row for each person; several with ``"repeated_measures"``. Rows with a missing value
        are left out.
    x, y : str
        Columns of numbers.
    subject : str, optional
        Column of the participants, for ``"repeated_measures"``.
    method : {"pearson", "spearman", "kendall", "repeated_measures"}
        Correlation coefficient.
    confidence : float
        Of the interval.

    Returns
    -------
    pandas.DataFrame
        One row: ``X``, ``Y``, ``method``, ``n``, ``r``, ``low``, ``high``, ``df``, ``p``,
        ``p_method``.

    Raises
    ------
    InputError
        If `subject` is missing for ``"repeated_measures"``, or given for another method.
    """
    if (method == "repeated_measures") != (subject is not None):
        raise InputError("`subject` goes with the method `repeated_measures`, and with it alone")
    rows = data.dropna(subset=[x, y, *([subject] if subject else [])])
    one, two = (rows[each].to_numpy(dtype=np.float64) for each in (x, y))
    found = (
        _correlation.correlation(one, two, method=method, confidence=confidence)
        if subject is None
        else _correlation.repeated_measures_correlation(
            one, two, rows[subject].astype(str), confidence=confidence
        )
    )
    return pd.DataFrame([{
        "X": x, "Y": y, "method": found.method, "n": found.n, "r": found.estimate,
        "low": found.low, "high": found.high, "df": found.df, "p": found.p,
        "p_method": found.p_method,
    }])  # fmt: skip


@with_columns
def icc(
    data: pd.DataFrame, *, dv: str, within: str, subject: str, confidence: float = 0.95
) -> pd.DataFrame:
    """Compute the six intraclass correlations of people × occasions.

    Parameters
    ----------
    data : pandas.DataFrame
        Long data with at most one row for each `subject` and level of `within`; people without
        every occasion are left out.
    dv, within, subject : str
        Columns of the values, the occasions, and the participants.
    confidence : float
        Of the intervals.

    Returns
    -------
    pandas.DataFrame
        A row for each form: ``form`` (1,1 … 3,k), ``icc``, ``low``, ``high``, ``F``, ``df1``,
        ``df2``, ``p``.

    Raises
    ------
    InputError
        If there are fewer than two people or occasions, or no variance is left for an error.
    """
    table = _paired(data, dv, within, subject).dropna()
    return pd.DataFrame([
        {
            "form": each.form, "icc": each.estimate, "low": each.low, "high": each.high,
            "F": each.f, "df1": each.df_effect, "df2": each.df_error, "p": each.p,
        }
        for each in _correlation.intraclass(table.to_numpy(float), confidence=confidence)
    ])  # fmt: skip


@with_columns
def kaplan_meier(
    data: pd.DataFrame,
    *,
    time: str,
    event: str,
    by: str | None = None,
    subject: str | None = None,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Estimate the share without an event over time.

    Parameters
    ----------
    data : pandas.DataFrame
        One row for each exposure.
    time, event : str
        Columns of seconds until the event or the end, and of 1 (event) or 0 (censored).
    by : str, optional
        Column of groups, each with a curve of its own.
    subject : str, optional
        Column of participants who come more than once: errors are robust then.
    confidence : float
        Of the intervals.

    Returns
    -------
    pandas.DataFrame
        A row for each time of each curve: ``by`` column, ``time_s``, ``at_risk``, ``events``,
        ``survival``, ``se``, ``low``, ``high``.

    Raises
    ------
    InputError
        If a time is missing or negative, or an event is neither 0 nor 1.
    """
    curves = {None: data} if by is None else dict(iter(data.groupby(by)))
    frames = []
    for name, rows in curves.items():
        found = _survival.kaplan_meier(
            rows[time], rows[event], people=_ids(rows, subject), confidence=confidence
        )  # fmt: skip
        frames.append(pd.DataFrame({
            **({} if by is None else {by: name}),
            "time_s": found.times_s, "at_risk": found.at_risk, "events": found.events,
            "survival": found.survival, "se": found.standard_errors, "low": found.low,
            "high": found.high,
        }))  # fmt: skip
    return pd.concat(frames, ignore_index=True)


@with_columns
def log_rank(
    data: pd.DataFrame, *, time: str, event: str, by: str, strata: str | None = None
) -> pd.DataFrame:
    """Test whether groups differ in the time to an event.

    Parameters
    ----------
    data, time, event, by
        As in `kaplan_meier`.
    strata : str, optional
        Column within which rows are compared, such as the participants of a within design.

    Returns
    -------
    pandas.DataFrame
        A row for each group: ``by`` column, ``n``, ``observed``, ``expected``, and the test
        ``chi2``, ``df``, ``p`` in every row: the exact p of two groups, where labellings can be
        listed, else that of χ².

    Raises
    ------
    InputError
        If there are fewer than two groups, no event, or nothing to compare within strata.
    """
    found = _survival.log_rank(data[time], data[event], data[by], strata=_ids(data, strata))
    return pd.DataFrame({
        by: found.groups, "n": found.n, "observed": found.observed, "expected": found.expected,
        "chi2": found.chi_square, "df": found.df, "p": found.p,
    })  # fmt: skip


@with_columns
def cox(
    data: pd.DataFrame,
    *,
    time: str,
    event: str,
    covariates: str | Sequence[str],
    subject: str | None = None,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Fit proportional hazards (Efron ties), with errors robust to repeated people.

    Parameters
    ----------
    data, time, event, subject, confidence
        As in `kaplan_meier`.
    covariates : str or sequence of str
        Columns of numbers; code a condition as 0 and 1.

    Returns
    -------
    pandas.DataFrame
        A row for each covariate: ``term``, ``hazard_ratio``, ``low``, ``high``, ``coef``, ``se``,
        ``Z``, ``p``.

    Raises
    ------
    InputError
        If there is no event, or a hazard ratio has no estimate.
    """
    found = _survival.cox(
        data[time], data[event], {name: data[name] for name in _names(covariates)},
        people=_ids(data, subject), confidence=confidence,
    )  # fmt: skip
    rows = [
        {
            "term": name, "hazard_ratio": each.ratio, "low": each.low, "high": each.high,
            "coef": each.coefficient,
            "se": each.standard_error if each.robust_error is None else each.robust_error,
            "Z": each.z, "p": each.p,
        }
        for name, each in found.effects.items()
    ]  # fmt: skip
    return _frame(rows, n=found.n, events=found.events, people=found.people, df=found.df)


def holm(p: ArrayLike) -> NDArray[np.float64]:
    """Adjust the p values of a family by Holm's step-down method.

    Parameters
    ----------
    p : array_like, shape (n,)
        NaN: a test that could not be made, which does not count.

    Returns
    -------
    ndarray, shape (n,)
        Adjusted p values in the order given.

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03]).round(4).tolist()
    [0.03, 0.06, 0.06]
    """
    values = [None if np.isnan(each) else float(each) for each in np.asarray(p, dtype=np.float64)]
    adjusted = _multiplicity.holm(values)
    return np.array([np.nan if each is None else each for each in adjusted], dtype=np.float64)


def _names(names: str | Sequence[str]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names)


def _paired(data: pd.DataFrame, dv: str, within: str, subject: str) -> pd.DataFrame:
    """Return a row for each participant and a column for each level, sorted."""
    rows = data.dropna(subset=[dv, within, subject])
    if rows.duplicated([subject, within]).any():
        raise InputError(
            f"a participant has two values of {dv!r} under one level of {within!r}; average them "
            "first"
        )
    return rows.pivot_table(index=subject, columns=within, values=dv, aggfunc="first")


def _groups(data: pd.DataFrame, dv: str, between: str) -> dict[Any, NDArray[np.float64]]:
    rows = data.dropna(subset=[dv, between])
    return {name: part[dv].to_numpy(dtype=np.float64) for name, part in rows.groupby(between)}


def _ids(data: pd.DataFrame, column: str | None) -> pd.Series | None:
    """Return the ids in an optional column as texts: 7 and "7" are one participant."""
    return None if column is None else data[column].astype(str)


def _each_pair(
    levels: Iterable[Any], factor: str, compare: Callable[[Any, Any], Row]
) -> pd.DataFrame:
    """Return a row for each pair of levels, with Holm's p over all of them after the p of each."""
    pairs = list(combinations(levels, 2))
    if not pairs:
        raise InputError(f"{factor!r} has fewer than two levels with values")
    rows = [{"A": a, "B": b, **compare(a, b)} for a, b in pairs]
    frame = pd.DataFrame(rows)
    adjusted = holm([np.nan if row["p"] is None else row["p"] for row in rows])
    frame.insert(list(frame).index("p") + 1, "p_holm", adjusted)
    return frame


def _step(values: NDArray[np.float64], unit: float | None) -> float:
    """Return the step of a scale, so that ties are exact."""
    there = values[np.isfinite(values)]
    for step in STEPS if unit is None else (unit,):
        try:
            as_integers(there, step)
        except InputError:
            continue
        return step
    raise InputError("values are not whole steps of a scale; give its step as `unit`, as 3.74")


def _estimate(found: Shift | EffectSize | None, name: str, prefix: str = "") -> Row:
    """Return an estimate with the ends of its interval; without one, all three missing."""
    ends = (f"{prefix}low", f"{prefix}high")
    if found is None:
        return dict.fromkeys((name, *ends))
    return {name: found.estimate, ends[0]: found.low, ends[1]: found.high}


def _t_rows(key: str, effects: Mapping[str, Estimate]) -> list[Row]:
    """Return a row for each effect of a model, with its name in column `key`."""
    return [
        {
            key: name, "estimate": each.estimate, "se": each.standard_error, "df": each.df,
            "T": each.t, "p": each.p, "low": each.low, "high": each.high,
        }
        for name, each in effects.items()
    ]  # fmt: skip


def _t_row(test: _t_tests.TTest | None) -> Row:
    if test is None:
        return {"n": None, "p": None}
    return {
        "n": test.n, "mean": test.mean, "se": test.standard_error, "df": test.df, "T": test.t,
        "p": test.p, "low": test.low, "high": test.high,
        **_estimate(test.hedges_g, "hedges_g", "g_"), "BF10": test.bayes_factor_10,
    }  # fmt: skip


def _anova_frame(effects: Sequence[AnovaEffect], n: int, excluded: int) -> pd.DataFrame:
    rows = []
    for each in effects:
        shape = each.sphericity
        rows.append({
            "effect": each.effect, "SS": each.sum_of_squares, "df1": each.df_effect,
            "df2": each.df_error, "F": each.f, "p": each.p,
            "eps_gg": shape and shape.greenhouse_geisser, "p_gg": each.p_greenhouse_geisser,
            "eps_hf": shape and shape.huynh_feldt, "p_hf": each.p_huynh_feldt,
            "W_mauchly": shape and shape.mauchly_w, "p_mauchly": shape and shape.mauchly_p,
            "ges": each.generalised_eta_squared,
            **_estimate(each.partial_eta_squared, "np2", "np2_"),
            "n": n, "excluded": excluded,
        })  # fmt: skip
    return pd.DataFrame(rows)


def _frame(rows: list[Row], **facts: Any) -> pd.DataFrame:
    frame = pd.DataFrame(rows)
    frame.attrs.update(facts)
    return frame
