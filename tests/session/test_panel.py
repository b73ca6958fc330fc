"""The panel's pages: what can be chosen, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest

from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset.inputs import HandInput, Inputs
from vrcomfort.questionnaire import Instrument, shipped_instruments
from vrcomfort.respondent.base import Exposure, Form, Withdrew
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_input import AWAY_S, DWELL_S, Pointing
from vrcomfort.respondent.panel_layout import Act, question_cells
from vrcomfort.respondent.panel_picture import LOOKED, Page, Picture
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import aim_at

SSQ, FMS = shipped_instruments()["ssq"], shipped_instruments()["fms"]


class ScriptedScreen:
    """A screen whose participant chooses cells by what they do, one per page."""

    def __init__(self, choices: Iterable[Callable[[Page], Pointing]]) -> None:
        self._choices = iter(choices)
        self._now = self._next = Pointing()
        self.pictures: list[Picture | None] = []
        self.points: list[tuple[float, float] | None] = []
        self.ticks = 0
        self.frames = 0
        self.absences_s: list[float] = []

    def watch(self, page: Page) -> None:
        self._next = next(self._choices)(page)

    def do(self, pointing: Pointing) -> None:
        self._now = pointing

    def show(self, picture: Picture | None) -> None:
        self.pictures.append(picture)

    def point_at(self, point: tuple[float, float] | None) -> None:
        self.points.append(point)

    def pointing(self) -> Pointing:
        return self._now

    def allow_absence(self, duration_s: float) -> None:
        self.absences_s.append(duration_s)

    def upcoming(self, pointing: Pointing) -> None:
        self._next = pointing

    def next_frame(self) -> None:
        self.frames += 1
        self._now = self._next
        self._next = replace(self._next, select=False, stop=False)

    def tick(self, hand: int) -> None:  # noqa: ARG002
        self.ticks += 1


def choose(act: Act, value: int = 0) -> Callable[[Page], Pointing]:
    def on(page: Page) -> Pointing:
        cell = next(each for each in page.cells if each.act is act and each.value == value)
        return Pointing(cell.center, select=True)

    return on


def ask(
    *choices: Callable[[Page], Pointing], instrument: Instrument = SSQ
) -> list[tuple[str, int | None]]:
    screen = ScriptedScreen(choices)
    heard: list[tuple[str, int | None]] = []
    person = PanelRespondent(screen, watch=screen.watch)
    person.ask(Form(instrument, "baseline"), lambda item, value, _: heard.append((item, value)))
    assert screen.pictures[-1] is None
    return heard


@pytest.mark.smoke
def test_every_item_is_asked_and_answers_can_be_corrected() -> None:
    """By asking the item before again, and in the list at the end; to decline is an answer."""
    answers = [choose(Act.ANSWER, index % 4) for index in range(1, 15)]
    first = [choose(Act.ANSWER, 3), choose(Act.BACK), choose(Act.ANSWER, 1)]
    last = [choose(Act.CORRECT, 2), choose(Act.ANSWER, 0), choose(Act.CONFIRM)]
    heard = ask(*first, *answers, choose(Act.DECLINE), *last)
    names = [item.name for item in SSQ.items]
    assert heard[:2] == [(names[0], 3), (names[0], 1)]
    assert heard[2:16] == [(names[index], index % 4) for index in range(1, 15)]
    assert heard[16:] == [(names[15], None), ("headache", 0)]


def test_stopping_is_asked_twice() -> None:
    assert ask(choose(Act.STOP), choose(Act.BACK), choose(Act.ANSWER), instrument=FMS) == [
        ("fms", 0)
    ]
    with pytest.raises(Withdrew):
        ask(choose(Act.STOP), choose(Act.WITHDRAW))


def test_a_wish_to_stop_an_exposure_is_asked_once_more_in_the_scene() -> None:
    screen = ScriptedScreen([])
    person = PanelRespondent(screen)
    person.start_exposure(Exposure(1, 1, "temple", "none", 60.0))

    def do(pointing: Pointing, at_s: float) -> None:
        screen.do(pointing)
        person.update(at_s)

    do(Pointing(stop=True), 0.1)
    do(Pointing(), 0.2)
    assert screen.pictures[-1] is not None
    do(Pointing(stop=True), 0.3)  # the same button is no yes
    do(Pointing(letters="n"), 0.4)
    assert screen.pictures[-1] is None
    do(Pointing(letters="q"), 0.5)
    with pytest.raises(Withdrew, match="during exposure"):
        do(Pointing(letters="y"), 0.6)
    assert screen.pictures[-1] is None


def test_an_exposure_begins_with_a_clear_view() -> None:
    screen = ScriptedScreen([])
    person = PanelRespondent(screen)
    assert person.resting(30.0)
    assert screen.pictures[-1] is not None
    person.start_exposure(Exposure(1, 1, "temple", "none", 60.0))
    assert screen.pictures[-1] is None


def test_a_scale_is_there_again_after_a_wish_to_stop_was_taken_back() -> None:
    screen = ScriptedScreen([])
    person = PanelRespondent(screen)
    person.start_exposure(Exposure(1, 1, "temple", "none", 60.0))
    person.prompt(FMS, 0.0, 5.0)
    for pointing in (Pointing(stop=True), Pointing(), Pointing(letters="n")):
        screen.do(pointing)
        person.update(1.0)
    screen.do(Pointing(digits="7", enter=True))
    person.update(1.5)
    assert person.rating(1.5) == 7


def test_a_rating_is_taken_while_the_exposure_runs() -> None:
    screen = ScriptedScreen([choose(Act.ANSWER, 7)])
    person = PanelRespondent(screen, watch=screen.watch)
    person.prompt(FMS, 1.0, 5.0)
    assert person.rating(1.0) is None
    screen.next_frame()
    person.update(1.1)
    assert person.rating(1.1) == 7
    assert screen.pictures[-1] is None


@pytest.mark.parametrize(("late_s", "rating"), [(6.0, 7), (6.5, 7), (7.0, None)])
def test_a_rating_counts_as_long_as_its_scale_is_there(late_s: float, rating: int | None) -> None:
    screen = ScriptedScreen([choose(Act.ANSWER, 7)])
    person = PanelRespondent(screen, watch=screen.watch)
    person.prompt(FMS, 1.0, 5.0)
    person.update(1.1)
    if late_s > 6.5:
        person.update(6.1)
        assert screen.pictures[-1] is None
    screen.next_frame()
    person.update(late_s)  # the frame in which it becomes late may still bring the answer
    assert person.rating(late_s) == rating


def test_a_panel_without_anything_to_point_with_says_so_after_a_while() -> None:
    now = {"s": 0.0}
    screen = ScriptedScreen([])
    person = PanelRespondent(screen, now_s=lambda: now["s"])
    person.prompt(FMS, 0.0, 60.0)

    def shown(pointing: Pointing, at_s: float) -> Picture:
        now["s"] = at_s
        screen.do(pointing)
        person.update(at_s)
        picture = screen.pictures[-1]
        assert picture is not None
        return picture

    usual = shown(Pointing(), 0.0)
    assert np.array_equal(shown(Pointing(unable=True), 1.0), usual)
    assert np.array_equal(shown(Pointing(unable=True), 2.9), usual)
    warned = shown(Pointing(unable=True), 3.1)
    changed = np.argwhere((warned != usual).any(axis=2))
    assert changed[:, 0].min() > 560
    assert changed[:, 0].max() < 648
    assert np.array_equal(shown(Pointing(), 3.2), usual)


def test_a_rest_says_how_long_it_is_and_can_be_stopped() -> None:
    screen = ScriptedScreen([choose(Act.BACK), choose(Act.WITHDRAW)])
    person = PanelRespondent(screen, watch=screen.watch)
    assert person.resting(121.0)
    long = screen.pictures[-1]
    assert person.resting(119.0)
    assert not np.array_equal(long, screen.pictures[-1])
    assert screen.absences_s == [121.0, 119.0]
    screen.upcoming(Pointing(stop=True))
    assert person.resting(60.0)  # not sure
    screen.upcoming(Pointing(stop=True))
    with pytest.raises(Withdrew, match="between exposures"):
        person.resting(59.0)
    person.rest(180.0)
    assert screen.pictures[-1] is None


class TwoHands:
    """A headset with both controllers before a panel."""

    head_pose = Pose(np.array([0.0, 1.6, 0.0]))

    def __init__(self) -> None:
        self.now = Inputs()

    def inputs(self) -> Inputs:
        return self.now

    def show_panel(self, _size_px: tuple[int, int], quad: Quad) -> TwoHands:
        self.quad = quad
        return self

    def draw(self, picture: Picture) -> None:
        """Show nothing."""


def test_of_two_controllers_the_one_that_presses_counts() -> None:
    headset = TwoHands()
    screen = PanelScreen(headset)
    screen.show(np.zeros((2, 2, 4), np.uint8))
    places = ((0.2, 0.5), (0.8, 0.5))

    def point(left: bool, right: bool) -> tuple[int, bool, tuple[float, float] | None]:
        hands = [
            HandInput(aim_at(headset.quad, place), select=pressed)
            for place, pressed in zip(places, (left, right), strict=True)
        ]
        headset.now = Inputs(*hands)
        seen = screen.pointing()
        return seen.hand, seen.select, seen.point

    for left, right, hand in [
        (False, False, 1),
        (True, False, 0),
        (False, False, 0),
        (False, True, 1),
        (False, False, 1),
    ]:
        number, select, place = point(left, right)
        assert (number, select) == (hand, left or right)
        assert place == pytest.approx(places[hand])
    headset.now = Inputs()
    assert screen.pointing().unable


def test_a_pointer_that_moves_on_a_cell_redraws_nothing() -> None:
    screen = ScriptedScreen([])
    person = PanelRespondent(screen, watch=lambda _: None)
    person.start_session(1)
    person.start_exposure(Exposure(1, 1, "temple", "plain", 60.0))
    person.prompt(FMS, 0.0, 10.0)
    screen.pictures.clear()
    for frame in range(5):
        screen.do(Pointing((0.1 + 0.001 * frame, 0.1)))
        person.update(0.1 * frame)
    assert len(screen.pictures) == 1
    assert screen.points == [(0.1 + 0.001 * frame, 0.1) for frame in range(5)]
    screen.do(Pointing())
    person.update(0.6)
    assert len(screen.pictures) == 1
    assert screen.points[-1] is None


class Looks:
    """Somebody who looks at cells of a page, one after the other: (cell or None, seconds)."""

    def __init__(self, screen: ScriptedScreen, looks: list[tuple[int | None, float]]) -> None:
        self.now_s = 0.0
        self._screen, self._looks = screen, looks
        self._page: Page | None = None
        self._until_s = -1.0
        screen.next_frame = self.next_frame  # type: ignore[method-assign]

    def watch(self, page: Page) -> None:
        self._page = page

    def next_frame(self) -> None:
        self.now_s += 0.05
        if self.now_s < self._until_s:
            return
        cell, seconds = self._looks.pop(0)
        self._until_s = self.now_s + seconds
        assert self._page is not None
        point = None if cell is None else self._page.cells[cell].center
        self._screen.do(Pointing(point, dwelling=True))


def look(looks: list[tuple[int | None, float]], **more: float) -> tuple[list[int | None], float]:
    """Answer one question by looks; return what was heard, and after how long."""
    screen = ScriptedScreen([])
    person = Looks(screen, looks)
    panel = PanelRespondent(screen, watch=person.watch, now_s=lambda: person.now_s, **more)
    heard: list[int | None] = []
    panel.ask(Form(FMS, "post"), lambda _, value, __: heard.append(value))
    return heard, person.now_s


@pytest.mark.parametrize("dwell_s", [DWELL_S, 0.5])
def test_two_looks_with_a_look_away_between_them_choose(dwell_s: float) -> None:
    heard, took_s = look([(None, 0.1), (1, 2.0), (None, 0.5), (1, 9.0)], dwell_s=dwell_s)
    assert heard == [1]
    assert took_s == pytest.approx(0.1 + 2.0 + 0.5 + AWAY_S + dwell_s, abs=0.2)


LONG_S = 3 * (AWAY_S + DWELL_S)


def test_a_look_that_was_there_when_the_page_opened_chooses_nothing() -> None:
    """The next question's answers stand where the last one was given."""
    with pytest.raises(IndexError):
        look([(1, LONG_S), (None, 0.5), (1, 2.0), (None, LONG_S)])
    heard, _ = look([(1, LONG_S), (None, 0.5), (1, 2.0), (None, 0.5), (1, 9.0)])
    assert heard == [1]


def test_looks_that_are_not_two_at_one_cell_choose_nothing() -> None:
    """One long look, looks at different cells, and a blink or a slip over the rim within one."""
    short_s = AWAY_S - 0.1
    for looks in (
        [(None, 0.1), (2, LONG_S)],
        [(None, 0.1), (2, 2.0), (3, 2.0), (2, 2.0), (4, 2.0)],
        [(None, 0.1), (1, 0.7), (None, short_s), (1, 0.7), (2, short_s), (1, LONG_S)],
    ):
        with pytest.raises(IndexError):
            look(looks)


def test_the_panel_shows_how_far_a_look_has_come_and_what_it_has_prepared() -> None:
    screen = ScriptedScreen([])
    person = Looks(screen, [(None, 0.1), (1, 2.0), (None, 0.5), (1, 9.0)])
    seen: list[tuple[float, int]] = []
    left, top, right, bottom = question_cells(FMS.answers, first=True)[1].box

    def show(picture: Picture | None) -> None:
        if picture is not None:
            cell = picture[top : bottom + 1, left : right + 1]
            seen.append((person.now_s, int((cell == LOOKED).all(axis=2).sum())))

    screen.show = show  # type: ignore[method-assign]
    panel = PanelRespondent(screen, watch=person.watch, now_s=lambda: person.now_s)
    panel.ask(Form(FMS, "post"), lambda *_: None)
    growing = [pixels for at_s, pixels in seen if at_s < 1.4]
    assert growing == sorted(growing)
    assert len(set(growing)) >= 6
    framed = {pixels for at_s, pixels in seen if 1.8 < at_s < 2.6}
    assert len(framed) == 1
    assert 0 < framed.pop() < max(pixels for _, pixels in seen)


def test_the_head_points_where_nothing_else_does() -> None:
    headset = TwoHands()
    for points_with_head in (False, True):
        screen = PanelScreen(headset, points_with_head=points_with_head)
        screen.show(np.zeros((768, 1024, 4), np.uint8))
        pointing = screen.pointing()
        assert pointing.unable != points_with_head
        assert (pointing.point is not None) == points_with_head
        assert pointing.dwelling == points_with_head
