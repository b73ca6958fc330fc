"""Numbers with their nouns."""

import pytest

from vrcomfort.plurals import counted, counted_doing


@pytest.mark.parametrize(
    ("number", "plural", "said"),
    [
        (0, "sessions", "0 sessions"),
        (1, "people", "1 person"),
        (1, "rows of trials.csv", "1 row of trials.csv"),
        (2, "rows of trials.csv", "2 rows of trials.csv"),
        (1, "complete pairs", "1 complete pair"),
    ],
)
def test_one_thing_is_in_the_singular(number: int, plural: str, said: str) -> None:
    assert counted(number, plural) == said


@pytest.mark.parametrize(
    ("number", "verb", "said"),
    [(1, "have", "1 row has"), (2, "have", "2 rows have"), (1, "divide", "1 row divides")],
)
def test_a_verb_goes_with_its_number(number: int, verb: str, said: str) -> None:
    assert counted_doing(number, "rows", verb) == said
