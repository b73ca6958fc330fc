"""The panel's pages: what can be chosen, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.geometry import Pose, Quad, yaw_pitch_roll
from vrcomfort.questionnaire import INSTRUMENTS, Instrument
from vrcomfort.respondent.base import Exposure, Form, Withdrew
from vrcomfort.respondent.panel import DWELL_S, PanelRespondent
from vrcomfort.respondent.panel_layout import SIZE_PX, Act, Cell, question_cells, review_cells
from vrcomfort.respondent.panel_picture import Page, Painter, Picture
from vrcomfort.respondent.pointing import Pointing
from vrcomfort.session.rehearsal import aim_at

SSQ, FMS = INSTRUMENTS["ssq"], INSTRUMENTS["fms"]


class ScriptedScreen:
    """A screen whose participant chooses cells by what they do, one per page."""

    def __init__(self, choices: Iterable[Callable[[Page], Pointing]]) -> None:
        self._choices = iter(choices)
        self._now = self._next = Pointing()
        self.pictures: list[Picture | None] = []
        self.ticks = 0
        self.frames = 0

    def watch(self, page: Page) -> None:
        self._next = next(self._choices)(page)

    def do(self, pointing: Pointing) -> None:
        self._now = pointing

    def show(self, picture: Picture | None) -> None:
        self.pictures.append(picture)

    def pointing(self) -> Pointing:
        return self._now

    def allow_absence(self, duration_s: float) -> None:
        """Stay."""

    def next_frame(self) -> None:
        self.frames += 1
        self._now = self._next
        self._next = replace(self._next, select=False)

    def tick(self, hand: int) -> None:  # noqa: ARG002
        self.ticks += 1


def choose(act: Act, value: int = 0) -> Callable[[Page], Pointing]:
    def on(page: Page) -> Pointing:
        cell = next(each for each in page.cells if each.act is act and each.value == value)
        return Pointing(cell.center, select=True)

    return on


def ask(*choices: Callable[[Page], Pointing]) -> list[tuple[str, int | None]]:
    screen = ScriptedScreen(choices)
    heard: list[tuple[str, int | None]] = []
    person = PanelRespondent(screen, watch=screen.watch)
    person.ask(Form(SSQ, "baseline"), lambda item, value, _: heard.append((item, value)))
    assert screen.pictures[-1] is None
    return heard


def test_every_item_is_asked_and_answers_can_be_corrected() -> None:
    answers = [choose(Act.ANSWER, index % 4) for index in range(16)]
    heard = ask(*answers, choose(Act.CORRECT, 2), choose(Act.ANSWER, 0), choose(Act.CONFIRM))
    names = [item.name for item in SSQ.items]
    assert heard[:16] == [(name, index % 4) for index, name in enumerate(names)]
    assert heard[16:] == [("headache", 0)]


def test_back_asks_the_item_before_again() -> None:
    first = [choose(Act.ANSWER, 3), choose(Act.BACK), choose(Act.ANSWER, 1)]
    rest = [choose(Act.ANSWER, 0)] * 15
    heard = ask(*first, *rest, choose(Act.CONFIRM))
    assert heard[:2] == [("general_discomfort", 3), ("general_discomfort", 1)]


def test_rather_not_say_is_an_answer() -> None:
    heard = ask(choose(Act.DECLINE), *[choose(Act.ANSWER, 0)] * 15, choose(Act.CONFIRM))
    assert heard[0] == ("general_discomfort", None)


def test_stopping_is_asked_twice() -> None:
    on = [choose(Act.STOP), choose(Act.BACK)]
    answers = [choose(Act.ANSWER, 0)] * 16
    assert len(ask(*on, *answers, choose(Act.CONFIRM))) == 16
    with pytest.raises(Withdrew):
        ask(choose(Act.STOP), choose(Act.STOP))


def test_the_stop_button_ends_an_exposure_at_once() -> None:
    screen = ScriptedScreen([])
    person = PanelRespondent(screen)
    person.start_exposure(Exposure(1, 1, "temple", "none", 60.0))
    person.endure(0.1)
    screen.do(Pointing(stop=True))
    with pytest.raises(Withdrew):
        person.endure(0.2)


def test_a_rating_is_taken_while_the_exposure_runs() -> None:
    screen = ScriptedScreen([choose(Act.ANSWER, 7)])
    person = PanelRespondent(screen, watch=screen.watch)
    person.prompt(FMS, 1.0, 5.0)
    assert person.rating(1.0) is None
    screen.next_frame()
    person.endure(1.1)
    assert person.rating(1.1) == 7
    assert screen.pictures[-1] is None


def test_a_look_chooses_after_it_has_rested() -> None:
    clock = iter(np.arange(0.0, 100.0, DWELL_S / 10))

    def look(page: Page) -> Pointing:
        return Pointing(page.cells[1].center, dwelling=True)

    screen = ScriptedScreen([look, choose(Act.ANSWER, 0)])
    person = PanelRespondent(screen, watch=screen.watch, now_s=lambda: float(next(clock)))
    heard: list[int | None] = []
    person.ask(Form(FMS, "post"), lambda _, value, __: heard.append(value))
    assert heard == [1]
    assert 8 <= screen.frames <= 12


@pytest.mark.parametrize("instrument", [SSQ, FMS], ids=lambda each: each.name)
def test_cells_lie_on_the_panel_and_do_not_overlap(instrument: Instrument) -> None:
    answers = [instrument.low] * len(instrument.items)
    for cells in (question_cells(instrument, first=False), review_cells(instrument, answers)):
        covered = np.zeros(SIZE_PX[::-1], dtype=int)
        for cell in cells:
            left, top, right, bottom = cell.box
            assert 0 <= left < right <= SIZE_PX[0]
            assert 0 <= top < bottom <= SIZE_PX[1]
            covered[top:bottom, left:right] += 1
        assert covered.max() == 1


def test_the_pointed_cell_and_the_pointer_are_seen() -> None:
    cells = question_cells(SSQ, first=True)
    page = Page("1 of 16", "Nausea", cells)
    painter = Painter()
    plain = painter.draw(page, None, None)
    pointed = painter.draw(page, cells[2].center, cells[2])
    assert plain.shape == (SIZE_PX[1], SIZE_PX[0], 4)
    changed = np.argwhere((plain != pointed).any(axis=2))
    left, top, right, bottom = cells[2].box
    assert changed.min(axis=0).tolist() >= [top, left]
    assert changed.max(axis=0).tolist() <= [bottom, right]


angles = st.floats(-1.2, 1.2)


@given(angles, angles, st.floats(0.02, 0.98), st.floats(0.02, 0.98))
def test_a_ray_aimed_at_a_point_of_a_panel_hits_it(
    yaw: float, pitch: float, right: float, down: float
) -> None:
    quad = Quad(Pose(np.array([1.0, 1.5, -2.0]), yaw_pitch_roll(yaw, pitch, 0.3)), (1.0, 0.75))
    hit = quad.intersection(aim_at(quad, (right, down)))
    assert hit == pytest.approx((right, down), abs=1e-9)


def test_a_ray_from_behind_or_beside_misses() -> None:
    quad = Quad(Pose(np.array([0.0, 0.0, -1.0])), (1.0, 1.0))
    assert quad.intersection(Pose()) == pytest.approx((0.5, 0.5))
    assert quad.intersection(Pose(np.array([0.0, 0.0, -2.0]))) is None
    assert quad.intersection(Pose(np.array([0.6, 0.0, 0.0]))) is None
    assert quad.intersection(Pose(orientation=yaw_pitch_roll(np.pi / 2, 0.0, 0.0))) is None


def test_a_cell_knows_its_middle() -> None:
    cell = Cell((0, 0, SIZE_PX[0], SIZE_PX[1] // 2), "", Act.ANSWER)
    assert cell.center == (0.5, 0.25)


def test_pointing_changes_the_pointed_cell_and_a_dot_and_nothing_else():
    cells = question_cells(FMS, first=True)
    page = Page("", FMS.instruction, cells, chosen=2)
    painter = Painter()
    plain = painter.draw(page, None, None)
    cell = cells[5]
    pointed = painter.draw(page, cell.center, cell)
    left, top, right, bottom = cell.box
    changed = np.any(plain != pointed, axis=2)
    assert changed[top : bottom + 1, left : right + 1].mean() > 0.9
    changed[top : bottom + 1, left : right + 1] = False
    assert not changed.any()
    dot = painter.draw(page, (0.0, 1.0), None)  # half of it lies beside the panel
    where = np.argwhere(np.any(plain != dot, axis=2))
    assert len(where)
    assert where.min(axis=0)[0] >= SIZE_PX[1] - 11
    assert where.max(axis=0)[1] <= 11
    assert np.array_equal(painter.draw(page, None, None), plain)
