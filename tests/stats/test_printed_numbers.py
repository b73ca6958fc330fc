"""What the papers print, against what follows from the rest of what they print."""

from tests.support.printed import BEGIN, END, ROWS, decimals, markdown
from tests.support.reference_table import PAGE


def test_printed_numbers_follow_or_do_not():
    for row in (row for row in ROWS if row.ours is not None):
        ours = row.ours()
        low, high = row.span() if row.span else (ours, ours)
        assert low <= ours <= high
        if " < " in row.printed or "below" in row.printed:
            follows = low < row.value
        elif row.value == 0:
            follows = abs(ours) < 0.01
        else:
            follows = round(low, decimals(row)) <= row.value <= round(high, decimals(row))
        assert follows == row.holds, (row.paper, row.printed, ours)


def test_the_page_has_the_table_that_was_computed():
    found = PAGE.read_text("utf-8").partition(BEGIN)[2].partition(END)[0].strip()
    assert found == markdown(), "run python -m tests.support.printed"
