"""Finds the columns that are sums of others, weighted or not, or the reverse of one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import nan

import numpy as np

from vrcomfort.importing.answers import number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_scales import FEWEST_ANSWERS
from vrcomfort.importing.suggest.cells import texts

_PARTS, _ROUNDED = (12, 8, 6, 5, 4, 3, 2), 0.051
"""Columns before a mean or a sum of them, and how far it may be rounded."""
_FEWEST_VALUES = 2
_ENOUGH = 200
"""Rows by which most columns are known to be no sum."""


def computed_columns(table: SourceTable, columns: Iterable[int]) -> set[int]:
    """Return the columns that are sums, weighted or not, or the reverse, of those before."""
    found, basis = set[int](), list[np.ndarray]()
    for column in sorted(columns):
        read = {text: number(text, table.decimal) for text in texts(table, column)}
        said = {text: value for text, value in read.items() if value is not None}
        values = np.array([said.get(cell, nan) for cell in table.column(column)])
        if any(_is_combination(values, basis[-n:]) for n in _PARTS):
            found.add(column)
        elif np.isnan(values).sum() * FEWEST_ANSWERS < len(values):
            basis.append(values)
    return found


def _is_combination(values: np.ndarray, others: Sequence[np.ndarray]) -> bool:
    """Return whether numbers are an exact sum of others, or the reverse of one of them.

    A sum has no negative weights unless it is a difference, which is below zero at times.
    """
    if len(values) > _ENOUGH and not _is_combination(
        values[:_ENOUGH], [each[:_ENOUGH] for each in others]
    ):
        return False
    cells = np.column_stack([np.ones(len(values)), *others, values])
    cells = cells[~np.isnan(cells).any(axis=1)]
    if len(cells) < len(others) + FEWEST_ANSWERS or len({*cells[:, -1]}) < _FEWEST_VALUES:
        return False
    weights, _, rank, _ = np.linalg.lstsq(cells[:, :-1], cells[:, -1])
    rounded = min(_ROUNDED, cells[:, -1].std() / 10)
    if rank <= len(others) or np.abs(cells[:, :-1] @ weights - cells[:, -1]).max() > rounded:
        return False
    parts = weights[1:][np.abs(weights[1:]) > _ROUNDED / 10]
    if len(parts) < 2:
        return len({*cells[:, -1]}) > 2 and bool(np.isclose(parts, -1.0, atol=rounded).any())
    return bool((parts > 0).all() or cells[:, -1].min() < 0)
