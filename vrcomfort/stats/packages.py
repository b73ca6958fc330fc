"""Packages that are loaded when something first needs them, with their warnings kept out."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

OF_THEIR_OWN = r"(pingouin|seaborn|sklearn|pandas_flavor|xarray|statsmodels|patsy)(\..*)?"
"""Modules whose warnings are about themselves: what changes in a package that they use."""


@contextmanager
def quiet() -> Iterator[None]:
    """Silence the packages' deprecation warnings about themselves; warnings about data stay."""
    with warnings.catch_warnings():
        for category in (DeprecationWarning, PendingDeprecationWarning, FutureWarning):
            warnings.filterwarnings("ignore", category=category, module=OF_THEIR_OWN)
        yield


@cache
def pingouin() -> Any:
    """Return pingouin (Vallat 2018); loading it takes two seconds, so it is loaded when needed.

    ``docs/statistics_checks.md`` lists what is not taken from it, with the tests that show why.
    """
    with quiet():
        return importlib.import_module("pingouin")
