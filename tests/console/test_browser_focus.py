"""A rating that appears at the console leaves whoever is about to press a button there."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("selenium", reason="selenium is not installed")

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tests.support.console_session import PROTOCOL, running_session
from tests.support.operator_page import NEEDS_BROWSER, OperatorPage, operator_page

pytestmark = NEEDS_BROWSER

RATED = (
    PROTOCOL[: PROTOCOL.index("[[questionnaires]]")]
    .replace("exposure_s = 4.0", "exposure_s = 60.0")
    .replace("training_s = 0.5\n", "")
    + '[[ratings]]\ninstrument = "fms"\nevery_s = 8.0\ntimeout_s = 7.5\n'
    + "stop_at = 15\nstop_in_a_row = 2\n"
)
COUNTED = """
window.sounds = 0;
window.AudioContext = class {
  constructor() { this.currentTime = 0; this.destination = {}; }
  createGain() {
    return { gain: { setValueAtTime() {}, exponentialRampToValueAtTime() {} }, connect() {} };
  }
  createOscillator() {
    return { frequency: {}, connect: (next) => next, start() { window.sounds += 1; }, stop() {} };
  }
};
"""


def place_of(page: OperatorPage, action: str) -> dict[str, float]:
    button = page.driver.find_element(By.CSS_SELECTOR, f'.actions [data-action="{action}"]')
    return dict(button.rect)


def test_a_rating_that_appears_takes_nothing_from_the_hand(tmp_path: Path, browser: str) -> None:
    with (
        running_session(
            tmp_path, "--size", "64x80", "--refresh-hz", "5", protocol=RATED
        ) as session,
        operator_page(browser) as page,
    ):
        page.open(session.next_address(1))
        page.driver.execute_script(COUNTED)
        page.until_step("waiting for the start")
        page.press_button("Start")
        page.until_step("exposure 1 of 2")
        while page.focused() != "Pause (P)":
            page.press(Keys.TAB)
        before = place_of(page, "pause")
        page.until(lambda: page.shows("question"))
        assert page.focused() == "Pause (P)"
        assert place_of(page, "pause") == before
        assert page.driver.execute_script("return window.sounds") == 1
        seven = page.driver.find_element(By.CSS_SELECTOR, '#answers [data-value="7"]')
        page.driver.execute_script("arguments[0].click()", seven)  # another hand, at the mouse
        page.until(lambda: page.text("curve-words").startswith("fms: 7 at"))
        assert page.focused() == "Pause (P)"
        stop = page.driver.find_element(By.CSS_SELECTOR, "#curve .stop-words").text
        assert stop == "fms stops at 15, 2 in a row"
        page.press(Keys.ENTER)
        page.until_step("— paused")
        assert page.focused() not in {"Skip", "Redo", "Abort", "Withdraw"}
