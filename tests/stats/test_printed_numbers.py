"""What the papers print, against what follows from the rest of what they print."""

import pytest

from tests.support.printed import BEGIN, END, ROWS, decimals, markdown
from tests.support.reference_table import PAGE

COMPUTED = [row for row in ROWS if row.ours is not None]


@pytest.mark.parametrize("row", [pytest.param(r, id=f"{r.paper}-{r.printed}") for r in COMPUTED])
def test_a_printed_number_follows_or_does_not(row):
    ours = row.ours()
    low, high = row.span() if row.span else (ours, ours)
    assert low <= ours <= high
    if " < " in row.printed or "below" in row.printed:
        follows = low < row.value
    elif row.value == 0:
        follows = abs(ours) < 0.01
    else:
        follows = round(low, decimals(row)) <= row.value <= round(high, decimals(row))
    assert follows == row.holds, ours


def test_the_page_has_the_table_that_was_computed():
    found = PAGE.read_text("utf-8").partition(BEGIN)[2].partition(END)[0].strip()
    assert found == markdown(), "run python -m tests.support.printed"
