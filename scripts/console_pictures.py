"""Makes the documentation's pictures of the operator's console.

Run ``python scripts/console_pictures.py docs/images``: a session with the playback headset, whose
page is opened in a Chromium without a screen. Needs the extra ``dev`` and ``scripts/browser.sh``.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.support.browser import find_browser
from tests.support.console_session import PROTOCOL, running_session
from tests.support.operator_page import OperatorPage, operator_page, screenshot

LONGER = (
    PROTOCOL.replace("exposure_s = 4.0", "exposure_s = 60.0")
    .replace("every_s = 1.2", "every_s = 4.0\nstop_at = 15\nstop_in_a_row = 2")
    .replace("timeout_s = 1.1", "timeout_s = 3.5")
)
SIZE = "320x400"
RATINGS = (1, 4, 9, 12)
PHONE_PX = (500, 1100)


def main() -> None:
    """Write ``console_questionnaire.png``, ``console_exposure.png`` and ``console_phone.png``."""
    folder = Path(sys.argv[1])
    browser = find_browser()
    if browser is None:
        sys.exit("there is no browser; scripts/browser.sh installs one")
    with (
        TemporaryDirectory() as study,
        running_session(Path(study), "--size", SIZE, protocol=LONGER) as session,
        operator_page(browser, (1360, 1000)) as page,
    ):
        page.open(session.next_address())
        page.press_button("Start")
        page.until_step("questionnaire ssq (baseline)")
        page.answer(*"0102001")
        screenshot(page, folder / "console_questionnaire.png")
        page.answer(*"000000000")
        page.until(lambda: page.shows("confirm"))
        page.press(Keys.ENTER)
        page.until_step("exposure 1 of 2")
        rate(page)
        page.press("n")
        page.press("looks at the ceiling", Keys.TAB, Keys.ENTER)
        page.until(lambda: page.shows("eyes"))
        screenshot(page, folder / "console_exposure.png")
        page.driver.set_window_size(*PHONE_PX)
        screenshot(page, folder / "console_phone.png")


def rate(page: OperatorPage) -> None:
    """Enter ratings as they are asked for, a little higher each time."""
    for rating in RATINGS:
        page.until(lambda: page.shows("question"))
        button = page.driver.find_element(By.CSS_SELECTOR, f'#answers [data-value="{rating}"]')
        page.driver.execute_script("arguments[0].click()", button)
        page.until(lambda: not page.shows("question"))


if __name__ == "__main__":
    main()
