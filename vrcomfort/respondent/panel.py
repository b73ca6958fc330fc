"""The participant answers in the headset, on a panel: points, and presses a button or dwells."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.questionnaire import Answers, Instrument
from vrcomfort.respondent import keyboard
from vrcomfort.respondent.base import Exposure, Form, Heard, InstructionContent, Withdrew, Written
from vrcomfort.respondent.keyboard import waiting_line
from vrcomfort.respondent.panel_input import (
    DWELL_S,
    FIST_S,
    Dwell,
    KeyChoice,
    LookDown,
    Pointing,
    Rest,
    Screen,
    by_button,
)
from vrcomfort.respondent.panel_layout import (
    Act,
    Cell,
    answer_cells,
    cell_at,
    ends_of,
    question_cells,
    rest_cells,
    review_cells,
)
from vrcomfort.respondent.panel_picture import (
    DwellProgress,
    Page,
    Painter,
    instruction_page,
    stop_page,
)

_AWAY_S = 60.0
"""Time that the headset may be unworn, from each frame on."""
UNABLE_S = 2.0
"""Time without any pointing device before the panel says so."""


class PanelRespondent:
    """A participant answering on the panel in the headset.

    Parameters
    ----------
    screen
        Where the questions stand.
    watch, chose
        Called with each page that opens, and with each cell that is chosen: a rehearsal's scripted
        participant looks on here.
    keyboard
        The participant has one: each question says how to use it.
    words
        What stands beside questions and answers, in the participant's language.
    dwell_s
        So long a look must rest on a cell, twice, to choose it, where there is no controller.
    look_down
        How a look asks to stop an exposure; None: none does.
    waiting_line
        Returns a line that an experimenter has typed, or None, without waiting.
    prompt
        Tells the experimenter what is to be typed.
    """

    name = "panel"

    def __init__(
        self,
        screen: Screen,
        *,
        now_s: Callable[[], float] = time.monotonic,
        watch: Callable[[Page], None] = lambda _: None,
        chose: Callable[[Cell], None] = lambda _: None,
        keyboard: bool = False,
        words: Words = ENGLISH,
        dwell_s: float = DWELL_S,
        look_down: LookDown | None = None,
        waiting_line: Callable[[], str | None] = waiting_line,
        prompt: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._waiting_line, self._prompt = waiting_line, prompt
        self._look_down = look_down
        self._fist = Rest(FIST_S, anew=True)
        self._words = words
        self._screen = screen
        self._now_s = now_s
        self._watch, self._chose = watch, chose
        self._keyboard = keyboard
        self._keys = KeyChoice()
        self._pointed: Cell | None = None
        self._dwell = Dwell(dwell_s)
        self._unable_since_s: float | None = None
        self._painter = Painter()
        self._drawn: tuple[object, ...] | None = None
        self._with_hint_of: tuple[Page, str, Page] | None = None
        self._scale: Page | None = None
        self._scale_until_s = 0.0
        self._stopping: Page | None = None
        self._stop_by_look = False
        self._rating: int | None = None
        self._told: tuple[InstructionContent, bool, Page] | None = None

    def start_session(self, session: int) -> None:
        """Do nothing: the session begins with its questions."""

    def start_exposure(self, exposure: Exposure) -> None:  # noqa: ARG002 - the panel is gone then
        """Clear the view."""
        self._hide()
        self._fist.forget()
        if self._look_down is not None:
            self._look_down.forget()

    def update(self, elapsed_s: float) -> None:
        """Take a wish to stop, and the rating that was asked for; a late one cannot be given.

        A wish to stop is asked once more, in the scene: the exposure goes on until it is confirmed.
        """
        pointing = self._screen.pointing()
        looked = self._look_down is not None and self._look_down.update(
            pointing.down_deg, self._now_s()
        )
        held = self._fist.update(pointing.fist, self._now_s())
        asked = looked or held or pointing.stop or keyboard.STOP in pointing.letters
        if self._stopping is None and asked:
            self._stopping, self._stop_by_look = stop_page(self._words), looked
            self._keys.forget()
            self._dwell.forget()
            self._take_decision(self._step(self._stopping, Pointing(letters=pointing.letters)))
        elif self._stopping is not None:
            answering = _by_look(pointing) if self._stop_by_look else pointing
            self._take_decision(self._step(self._stopping, answering))
        elif self._scale is not None:
            cell = self._step(self._scale, pointing)
            if cell is not None and cell.act is Act.ANSWER:
                self._rating, self._scale = cell.value, None
                self._leave_page()
        if self._scale is not None and elapsed_s > self._scale_until_s:
            self._scale = None
            self._leave_page()

    def _take_decision(self, cell: Cell | None) -> None:
        if cell is not None and cell.act is Act.WITHDRAW:
            self._hide()
            raise Withdrew("withdrew during exposure")
        if cell is not None:
            self._stopping = None
            self._leave_page()

    def _leave_page(self) -> None:
        """Clear the view, unless something else is still asked in it."""
        self._keys.forget()
        if self._scale is None and self._stopping is None:
            self._hide()

    def end_exposure(self, elapsed_s: float) -> None:  # noqa: ARG002
        """Clear the view."""
        self._hide()

    def prompt(self, instrument: Instrument, elapsed_s: float, timeout_s: float) -> None:
        """Show the scale in the scene; the answer is picked up by `update`."""
        answers = instrument.items[0].answers
        cells = answer_cells(question_cells(answers, first=True, words=self._words))
        self._rating, self._scale_until_s = None, elapsed_s + timeout_s
        self._keys.forget()
        self._dwell.forget()
        ends, hint = ends_of(answers), self._hint(answers)
        self._scale = Page("", instrument.instruction, cells, ends, hint=hint)
        self._watch(self._scale)

    def rating(self, elapsed_s: float) -> int | None:  # noqa: ARG002
        """Return the rating that has been given since `prompt`."""
        return self._rating

    def resting(self, left_s: float) -> bool:
        """Say how long the rest still is, while a frame passes; the participant may stop.

        Raises
        ------
        Withdrew
            If the participant stops, and says so twice.
        """
        self._screen.allow_absence(left_s)
        minutes, words = math.ceil(left_s / 60), self._words
        later = words.rest_minutes.format(minutes=minutes)
        page = Page(words.rest, later if minutes > 1 else words.rest_soon, rest_cells(words))
        self._screen.next_frame()
        cell = self._step(page, self._screen.pointing())
        if cell is not None:
            self._stop_if_sure("withdrew between exposures")
        return True

    def rest(self, duration_s: float) -> None:  # noqa: ARG002
        """Clear the view."""
        self._hide()

    def read(
        self,
        content: InstructionContent,
        elapsed_s: float,  # noqa: ARG002
        *,
        may_go_on: bool,
    ) -> float | None:
        """Show an instruction while a frame passes; with a button once the participant may go on.

        Raises
        ------
        Withdrew
            If the participant stops, and says so twice.
        """
        if content.away:
            self._screen.allow_absence(_AWAY_S)
        if self._told is None or self._told[:2] != (content, may_go_on):
            self._told = content, may_go_on, instruction_page(content, self._words, ready=may_go_on)
            self._keys.forget()
            self._dwell.forget()
            if may_go_on:
                self._watch(self._told[2])
        self._screen.next_frame()
        cell = self._step(self._told[2], self._screen.pointing())
        if cell is not None and cell.act is Act.CONFIRM:
            return None
        if cell is not None:
            self._stop_if_sure("withdrew between exposures")
            self._told = None  # the page is another one for whoever looks on
        return 0.0

    def leave(self) -> None:
        """Clear the view."""
        self._told = None
        self._hide()

    def ask(self, form: Form, heard: Heard) -> None:
        """Ask item by item, then show all answers for correction.

        Raises
        ------
        Withdrew
            If the participant stops, and says so twice.
        """
        instrument = form.instrument
        answers: list[int | None] = [None] * len(instrument.items)
        index = 0
        try:
            while index < len(instrument.items):
                index += self._question(instrument, index, answers, heard)
            while (wrong := self._review(instrument, answers)) is not None:
                self._question(instrument, wrong, answers, heard)
        finally:  # an operator may end it anywhere
            self._hide()

    def write(self, question: str) -> Written:
        """Have the participant tell it aloud, while an experimenter types at the terminal.

        Raises
        ------
        Withdrew
            If the participant stops, and says so twice.
        """
        page = Page(self._words.say_aloud, question, rest_cells(self._words))
        self._prompt(question)
        self._keys.forget()
        self._dwell.forget()
        since_s, lines = self._now_s(), list[str]()
        try:
            while True:
                self._screen.allow_absence(_AWAY_S)
                self._screen.next_frame()
                if self._step(page, self._screen.pointing()) is not None:
                    self._stop_if_sure("withdrew at a question")
                typed = self._waiting_line()
                if typed is not None and not typed.strip():
                    return Written("\n".join(lines), self._now_s() - since_s)
                lines += [] if typed is None else [typed.rstrip()]
        finally:  # an operator may end it
            self._hide()

    def decide(self, question: str) -> bool:
        """Let the participant wait, while the experimenter decides at the terminal.

        Raises
        ------
        Withdrew
            If the participant stops, and says so twice.
        """
        page = Page(self._words.rest, self._words.wait_experimenter, rest_cells(self._words))
        self._prompt(f"{question} ({keyboard.YES} = go on, {keyboard.NO} = stop)")
        self._keys.forget()
        self._dwell.forget()
        decided = {keyboard.YES: True, "yes": True, keyboard.NO: False, "no": False}
        try:
            while True:
                self._screen.allow_absence(_AWAY_S)
                self._screen.next_frame()
                if self._step(page, self._screen.pointing()) is not None:
                    self._stop_if_sure("withdrew before the exposure")
                line = (self._waiting_line() or "").strip().lower()
                if line in decided:
                    return decided[line]
        finally:  # an operator may end it
            self._hide()

    def _question(
        self, instrument: Instrument, index: int, answers: list[int | None], heard: Heard
    ) -> int:
        """Ask one item; return how many items to move on (−1 goes back)."""
        item = instrument.items[index]
        count = len(instrument.items)
        page = Page(
            title=self._words.place.format(
                number=index + 1, count=count, instruction=instrument.instruction
            ),
            question=item.text,
            cells=question_cells(item.answers, first=index == 0, words=self._words),
            ends=ends_of(item.answers),
            done=index / count,
            chosen=answers[index],
            hint=self._hint(item.answers),
        )
        since = self._now_s()
        cell = self._choose(page)
        if cell.act is Act.BACK:
            return -1
        answers[index] = cell.value if cell.act is Act.ANSWER else None
        heard(item.name, answers[index], self._now_s() - since)
        return 1

    def _review(self, instrument: Instrument, answers: list[int | None]) -> int | None:
        """Show all answers; return the index of the one to correct, or None if all are right."""
        if len(answers) == 1:
            return None
        cells = review_cells(instrument, answers, self._words)
        cell = self._choose(Page(self._words.review, "", cells))
        return cell.value if cell.act is Act.CORRECT else None

    def _hint(self, answers: Answers) -> str:
        if not self._keyboard:
            return ""
        asked = answers.asked
        return self._words.hint.format(answers=f"{asked[0]} … {asked[-1]}")

    def _choose(self, page: Page) -> Cell:
        """Show a page until a cell is chosen; a wish to stop is asked once more."""
        while True:
            cell = self._wait(page)
            if cell.act is not Act.STOP:
                return cell
            self._stop_if_sure("withdrew at a question")

    def _stop_if_sure(self, note: str) -> None:
        if self._wait(stop_page(self._words)).act is Act.WITHDRAW:
            self._hide()
            raise Withdrew(note)

    def _wait(self, page: Page) -> Cell:
        self._watch(page)
        self._keys.forget()
        self._dwell.forget()
        while True:
            self._screen.next_frame()  # first: a press belongs to one frame, and to one page
            cell = self._step(page, self._screen.pointing())
            if cell is not None:
                return cell

    def _step(self, page: Page, pointing: Pointing) -> Cell | None:
        """Draw the page as it is pointed at, and return the cell that is chosen, if one is."""
        pointed = cell_at(page.cells, pointing.point)
        if pointed is not None and pointed != self._pointed:
            self._keys.forget()  # whoever moves on pointing wants to point
        self._pointed = pointed
        self._keys.move(page.cells, pointing.arrow, pointing.digits, page.chosen)
        looked = self._dwell.update(pointed, self._now_s()) if pointing.dwelling else None
        self._draw(self._hinted(page, pointing), pointing, self._keys.cell or pointed)
        wanted = by_button(page.cells, pointing)
        if wanted is None and pointing.enter:
            wanted = self._keys.entered(page.cells)
        if wanted is None:
            wanted = looked if pointing.dwelling else pointed if pointing.select else None
        if wanted is not None:
            self._screen.tick(pointing.hand)
            self._chose(wanted)
        return wanted

    def _is_unable(self, pointing: Pointing) -> bool:
        """Return whether the participant has had nothing to point with for a while."""
        if not pointing.unable:
            self._unable_since_s = None
            return False
        if self._unable_since_s is None:
            self._unable_since_s = self._now_s()
        return self._now_s() - self._unable_since_s > UNABLE_S

    def _hinted(self, page: Page, pointing: Pointing) -> Page:
        """Return the page with the explanation for participants without a controller."""
        if self._is_unable(pointing):
            return self._with_hint(page, self._words.no_controller)
        return self._with_hint(page, self._words.look_twice) if pointing.dwelling else page

    def _with_hint(self, page: Page, hint: str) -> Page:
        """Return the same page for the same hint, so that it is drawn once."""
        if self._with_hint_of is None or self._with_hint_of[:2] != (page, hint):
            self._with_hint_of = page, hint, replace(page, hint=hint)
        return self._with_hint_of[2]

    def _draw(self, page: Page, pointing: Pointing, pointed: Cell | None) -> None:
        """Show a new picture only where it looks different; the pointer moves without."""
        looks = self._dwell.progress(self._now_s()) if pointing.dwelling else DwellProgress()
        drawn = (page, pointed, looks)
        if drawn != self._drawn:
            self._screen.show(self._painter.draw(page, pointed, looks))
            self._drawn = drawn
        self._screen.point_at(pointing.point)

    def _hide(self) -> None:
        self._scale = self._stopping = self._drawn = None
        self._screen.show(None)


def _by_look(pointing: Pointing) -> Pointing:
    """Let looks answer where no controller points: it may lie somewhere, still tracked."""
    if pointing.point is not None:
        return pointing
    return replace(pointing, point=pointing.looked, dwelling=True, unable=False)
