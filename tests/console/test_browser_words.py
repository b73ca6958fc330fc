"""A decision and an answer in one's own words, entered at the console in a real browser."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("selenium", reason="selenium is not installed")

from selenium.webdriver.common.keys import Keys

from tests.support.console_session import running_session
from tests.support.operator_page import NEEDS_BROWSER, operator_page
from tests.support.protocols import PLAIN, protocol_text
from tests.support.study import read_rows
from vrcomfort.records.session_rows import in_lines

pytestmark = NEEDS_BROWSER

PROTOCOL = protocol_text(
    """\
[[covariates]]
name = "age"

[[screening]]
covariate = "age"
above = 65

[[free_texts]]
name = "expects"
text = "What do you expect?"
when = "session_start"
""",
    name="aloud",
    exposure_s=60.0,
    scene="temple",
    conditions=[PLAIN],
)


def test_an_operator_decides_and_types_what_the_participant_says(
    tmp_path: Path, browser: str
) -> None:
    options = ("--covariate", "age=70")
    with (
        running_session(tmp_path, *options, protocol=PROTOCOL) as session,
        operator_page(browser) as page,
    ):
        page.open(session.next_address(1))
        page.until_step("waiting for the start")
        page.press_button("Start")
        page.until_step("screening")
        assert page.item() == "age is 70, above 65. Go on with this participant?"
        page.press_button("1 continue")
        page.until_step("free text expects")
        page.until(lambda: page.focused() == "What do you expect?")
        page.press("p", "a", "n", Keys.ENTER, "ü")  # none of them is a shortcut here
        page.press_button("Enter")
        page.until_step("exposure 1 of 1")
        (row,) = read_rows(session.ses / "texts.csv")
        assert in_lines(row["text"]) == "pan\nü"
        (row,) = read_rows(session.ses / "screening.csv")
        assert (row["rule"], row["value"], row["decision"]) == ("age above 65", "70.0", "go_on")
