"""Check the columns whose names functions of data frames are given."""

from __future__ import annotations

from collections import Counter
from functools import wraps
from inspect import signature
from typing import TYPE_CHECKING, ParamSpec, TypeVar, get_args

import numpy as np
import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.anova import SumsOfSquares
from vrcomfort.stats.correlation import Method
from vrcomfort.stats.mixed import Errors
from vrcomfort.stats.ranks import Alternative
from vrcomfort.stats.signed_rank import PValue, Zeros
from vrcomfort.stats.t_tests import Variances

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from inspect import BoundArguments

P = ParamSpec("P")
T = TypeVar("T")

WORDS = {
    "alternative": Alternative, "zeros": Zeros, "p_value": PValue, "variances": Variances,
    "method": Method, "sums_of_squares": SumsOfSquares, "errors": Errors,
}  # fmt: skip
"""Parameter → its possible words."""
OF_NUMBERS = ("dv", "x", "y", "time", "event", "covariates")
OF_LABELS = ("within", "between", "period", "subject", "by", "strata", "factors")
"""Parameters that name columns."""


def with_columns(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function whose first argument, a data frame, is checked first.

    Columns of numbers come as float64, NaN where a cell is blank.

    Raises
    ------
    InputError
        By the returned function: if there is no data frame, a column is missing, named twice or not
        unique, or holds something else than finite numbers where numbers are needed; or if a choice
        is not one of its words, or the confidence or the unit is out of range.
    """
    takes = signature(function)

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> T:
        given = takes.bind(*args, **kwargs)
        place = next(iter(takes.parameters))
        data = given.arguments[place]
        _check_choices(given.arguments)
        if not isinstance(data, pd.DataFrame):
            raise InputError(f"`{place}` should be a pandas data frame, got {type(data).__name__}")
        numbers = [*_named(given, OF_NUMBERS)]
        named = [*numbers, *_named(given, OF_LABELS)]
        for parameter, column in named:
            _check(data, parameter, column)
        twice = [column for column, n in Counter(each for _, each in named).items() if n > 1]
        if twice:
            raise InputError(f"column {twice[0]!r} is named twice; name another one")
        for factor, level in (given.arguments.get("references") or {}).items():
            _check(data, "references", factor)
            levels = sorted(map(str, data[factor].dropna().unique()))
            if level not in levels:
                hint = did_you_mean(str(level), levels)
                raise InputError(f"`references`: {factor!r} is never {level!r}; {hint}")
        there = {column: _numbers(data[column]) for _, column in numbers}
        given.arguments[place] = data.assign(**there)
        return function(*given.args, **given.kwargs)

    return checked


def _check_choices(arguments: Mapping[str, object]) -> None:
    for name, words in WORDS.items():
        value = arguments.get(name)
        if value is not None and value not in get_args(words):
            hint = did_you_mean(str(value), get_args(words))
            raise InputError(f"`{name}` cannot be {value!r}; {hint}")
    for name, most, example in (("confidence", 1.0, "0.95"), ("unit", np.inf, "3.74")):
        value = arguments.get(name)
        if value is None:
            continue
        if not isinstance(value, (int, float, np.number)) or not 0 < value < most:
            raise InputError(f"`{name}` cannot be {value!r}; write a number such as {example}")


def _named(given: BoundArguments, parameters: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield parameter and column of all columns that are named."""
    for parameter in parameters:
        names = given.arguments.get(parameter)
        if names is None:
            continue
        several = "Sequence" in str(given.signature.parameters[parameter].annotation)
        listed = tuple(names) if several and isinstance(names, (list, tuple)) else (names,)
        if not all(isinstance(name, str) for name in listed):
            raise InputError(f"`{parameter}` should be the name of a column, got {names!r}")
        yield from ((parameter, name) for name in listed)


def _check(data: pd.DataFrame, parameter: str, column: str) -> None:
    count = list(data.columns).count(column)
    if not count:
        hint = did_you_mean(column, map(str, data.columns))
        raise InputError(f"`{parameter}`: there is no column {column!r}; {hint}")
    if count > 1:
        raise InputError(f"`{parameter}`: there are {count} columns {column!r}; rename them")


def _numbers(column: pd.Series) -> pd.Series:
    not_real = column.dtype.kind in "cmM"  # complex numbers, durations, dates
    try:
        found = None if not_real else pd.to_numeric(column).astype(np.float64)
    except (TypeError, ValueError):
        found = None
    if found is None:
        raise InputError(f"column {column.name!r} should hold numbers, not {_example(column)}")
    if np.isinf(found.to_numpy()).any():
        raise InputError(f"column {column.name!r} has an infinite number; leave it blank")
    return found


def _example(column: pd.Series) -> str:
    """Return a cell that is no number, as the message says it."""
    for cell in column.dropna():
        try:
            float(cell)
        except (TypeError, ValueError):
            return repr(cell)
    return str(column.dtype)
