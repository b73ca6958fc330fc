"""Random reports contradict themselves nowhere. `make random-reports` makes 2,000 of them."""

import os

import pytest

from tests.support.random_studies import faults
from vrcomfort.errors import InputError

FEW = 40
COUNT = int(os.environ.get("VRCOMFORT_RANDOM_REPORTS", FEW))


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, COUNT, 10))
def test_no_two_statements_of_a_random_report_contradict_each_other(tmp_path, first):
    for seed in range(first, first + 10):
        folder = tmp_path / str(seed)
        folder.mkdir()
        try:
            found = faults(folder, seed)
        except InputError:  # one sentence on what the data do not allow, as nobody's answers
            continue
        assert found == [], f"seed {seed}"
