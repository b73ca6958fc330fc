"""A session steered by two operators in real browsers, by keyboard alone."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("selenium", reason="selenium is not installed")

from selenium.webdriver.common.keys import Keys

from tests.support.console_session import PROTOCOL, RunningSession, running_session
from tests.support.operator_page import NEEDS_BROWSER, operator_page
from tests.support.study import read_rows
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import read_manifest, read_participants

pytestmark = NEEDS_BROWSER


LONG = PROTOCOL.partition("\n[[ratings]]")[0].replace("exposure_s = 4.0", "exposure_s = 10.0")
"""Long enough for all that is done in an exposure; no rating takes the focus meanwhile."""


@pytest.fixture(scope="module")
def steered(tmp_path_factory: pytest.TempPathFactory, browser: str) -> RunningSession:
    """Return a session that two operators have taken somebody through, to a withdrawal."""
    folder = tmp_path_factory.mktemp("steered")
    with (
        running_session(folder, "--refresh-hz", "20", protocol=LONG) as session,
        operator_page(browser) as first,
        operator_page(browser) as second,
    ):
        first.open(session.next_address(1))
        first.until_step("waiting for the start")
        # 3 × 16 items of 4 s, two exposures of 10 s, a training of 0.5 s
        assert first.text("session-left") == "About 4 min left of the session (an estimate)."
        first.press_button("Start")
        first.until_step("questionnaire ssq (baseline)")
        first.answer(*"10230123")
        first.reload()
        assert first.item().startswith("9. ")  # the answers before are still there
        assert "2 moderate" in first.text("items")
        first.press_button("Rather not say")
        first.until(lambda: first.text("item").startswith("10. "))
        second.open(session.next_address(2))
        assert second.text("you") == "B"
        assert second.item() == first.item()
        second.answer(*"1111111")
        first.until(lambda: first.shows("confirm"))
        first.press(Keys.ENTER)  # the focus is there

        first.until_step("exposure 1 of 2, attempt 1")
        first.press("p")
        for page in (first, second):
            page.until_step("attempt 1: plain in temple — paused")
        second.press_button("Abort")  # which opens a question that belongs to this step
        first.press("n")
        first.press("sits down, <b>fine</b>", Keys.TAB, Keys.ENTER)
        second.until(lambda: "A, note: sits down, <b>fine</b>" in second.text("lines"))
        first.press_button("Redo")
        first.until_step("exposure 1 of 2, attempt 2")
        second.press("too late", Keys.TAB, Keys.ENTER)
        second.until(lambda: "abort was meant for step" in second.text("refusal"))
        assert first.text("refusal") == ""
        second.press("p")
        first.until_step("— paused")
        second.press("p")

        first.until_step("questionnaire ssq (post)")
        first.answer(*"0" * 16)
        first.press(Keys.ENTER)
        first.until_step("exposure 2 of 2, attempt 1")
        first.press_button("Withdraw")
        second.until(lambda: second.shows("withdrawing"))
        second.press_button("No, continue")
        first.until(lambda: not first.shows("withdrawing"))
        first.press_button("Withdraw")
        first.until(lambda: first.shows("withdrawing"))
        first.press("felt ill", Keys.TAB, Keys.ENTER)
        first.until_step("questionnaire ssq (post)")
        second.press_button("Skip")
        for page in (first, second):
            page.until(lambda page=page: "has ended: withdrawn" in page.text("step"))
            assert page.text("session-left") == ""
        assert session.ended() == 0
        return session


def rows(session: RunningSession, name: str) -> list[dict[str, str]]:
    return read_rows(session.ses / f"{name}.csv")


def test_the_folder_has_the_answers_that_were_entered(steered: RunningSession) -> None:
    answers = rows(steered, "questionnaires")
    baseline = [row["response"] for row in answers if row["timepoint"] == "baseline"]
    assert baseline == [*"10230123", "", *"1111111"]
    post = [row["response"] for row in answers if row["timepoint"] == "post"]
    assert post == ["0"] * 16
    for row in answers:
        assert float(row["asked_s"]) <= float(row["answered_s"])
    assert read_manifest(steered.ses)["respondent"] == "console"


def test_the_folder_has_the_attempts_the_pauses_and_the_withdrawal(steered: RunningSession) -> None:
    trials = [
        (r["trial"], r["attempt"], r["status"], r["abort_code"]) for r in rows(steered, "trials")
    ]
    assert trials == [
        ("1", "1", "aborted", "redone"),
        ("1", "2", "completed", ""),
        ("2", "1", "withdrawn", "participant"),
    ]
    events = rows(steered, "events")
    pauses = [row for row in events if row["name"] == "pause"]
    assert [row["detail"].split(":")[0][-1] for row in pauses] == ["1", "2"]
    assert all(float(row["duration_s"]) > 0 for row in pauses)
    (person,) = read_participants(steered.folder / "study")
    assert person.status == "withdrawn"
    assert "withdrawn by A: felt ill" in person.note


def test_the_events_say_what_each_operator_did(steered: RunningSession) -> None:
    events = [(r["name"], r["detail"]) for r in rows(steered, "events") if "operator_" in r["name"]]
    answered = [detail[0] for name, detail in events if name == "operator_answer"]
    assert answered == ["A"] * 9 + ["B"] * 7 + ["A"] * 16
    others = [(name, detail[0]) for name, detail in events if "answer" not in name]
    assert others == [
        ("operator_start", "A"), ("operator_confirm", "A"), ("operator_pause", "A"),
        ("operator_note", "A"), ("operator_redo", "A"), ("operator_refused", "B"),
        ("operator_pause", "B"), ("operator_go_on", "B"), ("operator_confirm", "A"),
        ("operator_withdraw", "A"), ("operator_withdraw_not", "B"), ("operator_withdraw", "A"),
        ("operator_withdraw_surely", "A"), ("operator_skip", "B"),
    ]  # fmt: skip


def test_the_folder_is_whole_and_the_terminal_had_the_same_steps(steered: RunningSession) -> None:
    assert [str(each) for each in verify_study(steered.folder / "study").faults] == []
    told = "".join(steered.lines)
    for words in ("step 1: waiting for the start", "A, pause", "attempt 2: plain in temple"):
        assert words in told
    assert Path(steered.ses / "manifest.json").exists()
