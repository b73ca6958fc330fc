"""Numbers with their nouns."""

import pytest

from vrcomfort.plurals import counted


@pytest.mark.parametrize(
    ("number", "plural", "said"),
    [
        (0, "sessions", "0 sessions"),
        (1, "people", "1 person"),
        (1, "rows of trials.csv", "1 row of trials.csv"),
        (2, "rows of trials.csv", "2 rows of trials.csv"),
    ],
)
def test_one_thing_is_in_the_singular(number: int, plural: str, said: str) -> None:
    assert counted(number, plural) == said
