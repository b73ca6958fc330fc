"""An operator at the console's page in a Chromium without a screen, with a keyboard alone."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webdriver import WebDriver

from tests.support.browser import OPTIONS
from tests.support.waiting import WAIT_S, wait_for

NEEDS_BROWSER = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.timeout(1800),
    pytest.mark.skipif(shutil.which("chromedriver") is None, reason="there is no chromedriver"),
]
"""Marks of the files whose tests steer a session in a browser."""


class OperatorPage:
    """One browser with one page."""

    def __init__(self, driver: WebDriver) -> None:
        self.driver = driver

    def open(self, address: str) -> None:
        """Open an address, and wait for the session."""
        self.driver.get(address)
        self.until(lambda: self.text("link") == "Connected." and self.text("step"))

    def reload(self) -> None:
        """Load the page again."""
        self.driver.refresh()
        self.until(lambda: self.text("link") == "Connected." and self.text("step"))

    def text(self, name: str) -> str:
        """Return what an element says."""
        return str(self.driver.find_element(By.ID, name).text)

    def shows(self, name: str) -> bool:
        """Return whether an element is seen."""
        return bool(self.driver.find_element(By.ID, name).is_displayed())

    def press(self, *keys: str) -> None:
        """Press keys, wherever the focus is."""
        for key in keys:
            ActionChains(self.driver).send_keys(key).perform()

    def focused(self) -> str:
        """Return the text of what has the focus."""
        script = "const e = document.activeElement; return e.ariaLabel || e.textContent.trim();"
        return str(self.driver.execute_script(script))

    def press_button(self, name: str) -> None:
        """Go with the tab key to a button, and press Enter."""
        deadline = time.monotonic() + WAIT_S
        while self.focused() != name:
            assert time.monotonic() < deadline, f"{name!r} cannot be reached with the tab key"
            self.press(Keys.TAB)
        self.press(Keys.ENTER)

    def until(self, wanted: Callable[[], Any]) -> Any:
        """Wait for something."""
        return wait_for(wanted, self.seen)

    def until_step(self, words: str) -> None:
        """Wait for a step with these words in its name, which begins with a capital."""
        self.until(lambda: words.lower() in self.text("step").lower())

    def seen(self) -> str:
        """Return what the page says, for the message of a test that fails."""
        return str(self.driver.find_element(By.TAG_NAME, "body").text)

    def item(self) -> str:
        """Wait until something is asked, which may be a moment after its step; return the text."""
        return str(self.until(lambda: self.text("item")))

    def answer(self, *digits: str) -> None:
        """Answer question after question with number keys."""
        for digit in digits:
            before = self.item()
            self.press(digit)
            self.until(lambda before=before: self.text("item") != before)


@contextmanager
def operator_page(browser: str, size_px: tuple[int, int] = (1100, 1400)) -> Iterator[OperatorPage]:
    """Start a browser of one's own: no cookie is shared with another."""
    driver_path = shutil.which("chromedriver")
    assert driver_path, "scripts/browser.sh installs chromium and its driver"
    profile = mkdtemp()
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    width, height = size_px
    for word in (*OPTIONS, f"--user-data-dir={profile}"):
        options.add_argument(word)
    options.add_argument(f"--window-size={width},{height}")
    service = webdriver.ChromeService(driver_path)
    driver = webdriver.Chrome(options, service)
    try:
        yield OperatorPage(driver)
    finally:
        driver.quit()
        shutil.rmtree(profile, ignore_errors=True)


def screenshot(page: OperatorPage, file: Path) -> None:
    """Write what the page looks like as PNG."""
    file.write_bytes(page.driver.get_screenshot_as_png())
