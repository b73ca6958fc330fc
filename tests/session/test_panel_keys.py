"""Choosing on the panel with the keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose
from vrcomfort.headset.inputs import HandInput, Inputs, KeyInput
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.respondent.base import Form, Withdrew
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_input import KeyChoice, Pointing, beside
from vrcomfort.respondent.panel_layout import Act, Cell, question_cells, review_cells
from vrcomfort.respondent.panel_picture import Picture
from vrcomfort.respondent.terminal import TerminalRespondent
from vrcomfort.session.panel_screen import PanelScreen

SSQ, FMS = shipped_instruments()["ssq"], shipped_instruments()["fms"]
LEFT, RIGHT, UP, DOWN = (-1, 0), (1, 0), (0, -1), (0, 1)
PAGES = [
    question_cells(SSQ.answers, first=False),
    question_cells(FMS.answers, first=True),
    review_cells(SSQ, [0] * 16),
]


class TypingScreen:
    """A screen whose participant does one thing per frame."""

    def __init__(self, *doings: Pointing) -> None:
        self._doings = iter(doings)
        self._now = Pointing()

    def point_at(self, point: tuple[float, float] | None) -> None:
        """Show no pointer."""

    def show(self, picture: Picture | None) -> None:
        """Show it to nobody."""

    def pointing(self) -> Pointing:
        return self._now

    def allow_absence(self, duration_s: float) -> None:
        """Stay."""

    def next_frame(self) -> None:
        self._now = next(self._doings)

    def tick(self, hand: int) -> None:
        """Do not tick."""


ENTER = Pointing(enter=True)


def typed(digits: str) -> Pointing:
    return Pointing(digits=digits)


def pressed(*arrow: int) -> Pointing:
    return Pointing(arrow=(arrow[0], arrow[1]))


def ask_one(*doings: Pointing) -> int | None:
    heard: list[int | None] = []
    person = PanelRespondent(TypingScreen(*doings), keyboard=True)
    person.ask(Form(FMS, "post"), lambda _, value, __: heard.append(value))
    return heard[-1]


@pytest.mark.parametrize(
    ("doings", "answer"),
    [
        ([typed("7"), ENTER], 7),
        ([typed("1"), typed("7"), ENTER], 17),
        ([typed("17"), ENTER], 17),
        ([typed("29"), ENTER], 9),  # there is no 29: the 9 begins anew
        ([pressed(1, 0), pressed(3, 0), ENTER], 3),  # the first press comes to the first answer
        ([typed("4"), pressed(-1, 0), ENTER], 3),
        ([typed("4"), pressed(-9, 0), ENTER], 0),
        ([ENTER, typed("5"), ENTER], 5),  # Enter alone chooses nothing
        ([Pointing(digits="5", enter=True)], 5),  # both within one slow frame
    ],
)
def test_numbers_and_arrows_lead_to_an_answer(doings: list[Pointing], answer: int) -> None:
    assert ask_one(*doings) == answer


def answer_all(*doings: Pointing) -> list[tuple[str, int | None]]:
    heard: list[tuple[str, int | None]] = []
    person = PanelRespondent(TypingScreen(*doings))
    person.ask(Form(SSQ, "baseline"), lambda item, value, _: heard.append((item, value)))
    return heard


def test_numbers_are_the_answers_and_the_review_is_confirmed() -> None:
    answers = [each for index in range(16) for each in (typed(str(index % 4)), ENTER)]
    heard = answer_all(*answers, pressed(0, 1), ENTER)
    assert [value for _, value in heard] == [index % 4 for index in range(16)]


SAME_KEYS = ["1", "2", "b", "3", "-", *["0"] * 13, "16", "2", "4", "b", "7", "3", ""]
"""What an operator types: a correction, one answer declined, and two more at the end."""


def test_the_same_keys_give_the_same_answers_in_the_terminal_and_on_a_panel() -> None:
    lines = iter(SAME_KEYS)
    terminal = TerminalRespondent(Console(file=StringIO()), read_line=lambda _: next(lines))
    typed_answers: list[tuple[str, int | None]] = []
    terminal.ask(Form(SSQ, "post"), lambda item, value, _: typed_answers.append((item, value)))
    doings = []
    for word in SAME_KEYS:
        doings += [Pointing(letters=word)] if word in {"b", "-"} else [typed(word), ENTER]
    assert answer_all(*doings) == typed_answers


def test_the_same_keys_withdraw_in_the_terminal_and_on_a_panel() -> None:
    words = ["q", "n", "q", "q", "n", "1", "q", "y"]
    lines = iter(words)
    terminal = TerminalRespondent(Console(file=StringIO()), read_line=lambda _: next(lines))
    for_terminal: list[int | None] = []
    with pytest.raises(Withdrew, match="at a question"):
        terminal.ask(Form(FMS, "post"), lambda _, value, __: for_terminal.append(value))
    doings = [Pointing(letters=word) for word in "qnqqn"]
    with pytest.raises(Withdrew, match="at a question"):
        ask_one(*doings, Pointing(letters="q"), Pointing(letters="y"))
    assert for_terminal == [1]


def test_pointing_elsewhere_ends_the_choice_by_keys() -> None:
    cells = question_cells(FMS.answers, first=True)
    at_nine = Pointing(cells[9].center)
    click = Pointing(cells[9].center, select=True)
    assert ask_one(typed("4"), at_nine, click) == 9
    assert ask_one(at_nine, Pointing(cells[9].center, digits="4"), ENTER) == 4


@pytest.mark.parametrize("answer", [0, 15, 100])
def test_digits_make_an_answer_of_a_scale_in_steps(answer: int) -> None:
    cells = question_cells(shipped_instruments()["nasa_tlx"].answers, first=True)
    choice = KeyChoice()
    choice.move(cells, (0, 0), str(answer), None)
    assert choice.cell is not None
    assert choice.cell.value == answer


def test_escape_is_asked_once_more() -> None:
    stop = Pointing(stop=True)
    assert ask_one(stop, stop, pressed(1, 0), ENTER, typed("2"), ENTER) == 2
    with pytest.raises(Withdrew):
        ask_one(stop, stop, stop, pressed(1, 0), pressed(1, 0), ENTER)


@given(st.sampled_from(PAGES), st.lists(st.sampled_from([LEFT, RIGHT, UP, DOWN]), max_size=30))
def test_arrows_stay_on_the_page_and_every_step_has_a_way_back_to_its_row(
    cells: list[Cell], way: list[tuple[int, int]]
) -> None:
    cell = cells[0]
    for step in way:
        there = beside(cells, cell, step)
        assert there in cells
        if there != cell and step[0]:
            assert beside(cells, there, (-step[0], 0)).box[1] <= there.box[3]
        cell = there


@pytest.mark.parametrize("cells", PAGES)
def test_every_cell_can_be_reached_by_arrows(cells: list[Cell]) -> None:
    reached, left = {cells[0]}, [cells[0]]
    while left:
        cell = left.pop()
        new = {beside(cells, cell, step) for step in (LEFT, RIGHT, UP, DOWN)} - reached
        reached |= new
        left += new
    assert reached == set(cells)


def test_down_leads_from_the_answers_to_the_foot() -> None:
    cells = question_cells(SSQ.answers, first=False)
    choice = KeyChoice()
    choice.move(cells, (0, 0), "0", None)
    choice.move(cells, DOWN, "", None)
    assert choice.cell is not None
    assert choice.cell.act is Act.BACK


class KeyHeadset:
    """A headset in which keys are pressed."""

    head_pose = Pose()

    def __init__(self, inputs: Inputs) -> None:
        self._inputs = inputs

    def inputs(self) -> Inputs:
        return self._inputs

    def frames(self) -> Iterator[Frame]:
        return iter(())

    def submit(self, frame: Frame, eyes: None) -> None:
        """Show nothing."""

    def tick(self, hand: int) -> None:
        """Do not tick."""

    def show_panel(self, size_px: object, quad: object) -> object:  # noqa: ARG002
        raise AssertionError("no picture was shown")


def test_keys_of_a_headset_reach_the_panel() -> None:
    keys = KeyInput(arrow=(1, -2), digits="12", letters="b", enter=True, back=True, stop=True)
    seen = PanelScreen(KeyHeadset(Inputs(right=HandInput(), keys=keys))).pointing()
    assert (seen.arrow, seen.digits, seen.letters) == ((1, -2), "12", "b")
    assert seen.enter
    assert seen.back
    assert seen.stop
