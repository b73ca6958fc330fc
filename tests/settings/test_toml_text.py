"""What is written as TOML reads back as it was."""

from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.errors import InputError
from vrcomfort.settings import read_toml, toml_key, toml_value

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


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("a = 1\na = 2", "keep one of the lines"),
        ("[a]\nb = 1\n[a]", "below one heading"),
        ("a = x", "a text needs quotes"),
        ('a = "x\nb = 1', "close the quotes"),
        ("a = 5 cm", "a text needs quotes"),
        ("a b = 1", "write key = value"),
        ("a = [1, 2", "close the list"),
        ("a = { b = 1\n}", "in the same line"),
        ("[a\nb = 1", "close the heading"),
        ('a = "C:\\data"', "write / for"),
        ('a = "C:\\Users"', "write / for"),
        ("a = { b = 1, }", "take the comma"),
        ("ä = 1", "a line is key = value"),
    ],
)
def test_what_is_no_toml_is_told_with_its_remedy(text, remedy):
    with pytest.raises(InputError, match=f"this is not valid TOML: .*{re.escape(remedy)}"):
        read_toml(text, None)
