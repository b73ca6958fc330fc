"""What is written as TOML reads back as it was."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.settings import toml_key, toml_value

texts = st.text(st.characters(exclude_categories=["Cs"]))
plain = st.one_of(
    st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), texts,
    st.dates(), st.times(), st.datetimes(),
)  # fmt: skip
values = st.recursive(
    plain, lambda inner: st.lists(inner) | st.dictionaries(texts, inner), max_leaves=5
)


@given(texts, values)
def test_any_value_reads_back_as_it_was(key, value):
    assert tomllib.loads(f"{toml_key(key)} = {toml_value(value)}") == {key: value}


@pytest.mark.parametrize("value", [np.float64(1e-7), np.float64(0.1), 22.740000000000002, 1e300])
def test_any_float_is_a_number(value):
    assert tomllib.loads(f"x = {toml_value(value)}") == {"x": value}


def test_what_toml_does_not_have_is_refused():
    with pytest.raises(TypeError):
        toml_value({"x": None})
