"""A rehearsal without a person: a trace moves the head, a script answers with the controllers.

Everything takes the real way: poses and button presses enter the runtime, and come back through
OpenXR to the session and to the panel. The scripted hand goes by what has come back, as a person
goes by what they see; so a rehearsal ends the same on a slow machine.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose, Quad, normalize, turn_to
from vrcomfort.headset.monado import RemoteFeed, RemoteHand, RemoteState
from vrcomfort.respondent.panel_layout import Act, Cell, cell_at
from vrcomfort.respondent.panel_picture import Page
from vrcomfort.session.panel_screen import PanelScreen

REACH_M = 0.5
"""How far before the panel the hand is held."""


class Rehearsal:
    """Feeds a runtime, one state before each frame.

    Parameters
    ----------
    feed
        The runtime's driver.
    heads
        stage-from-head for each frame of an exposure; the head holds still at questions.
    answers
        The answers to all questions, in the order in which they are given: one that came too late
        for its question is given to the next.

    Attributes
    ----------
    screen
        Where the questions stand; set it before the first one.
    fed, said
        The head poses sent, and the answers given, so far.
    """

    def __init__(self, feed: RemoteFeed, heads: Iterator[Pose], answers: Iterator[int]) -> None:
        self._feed = feed
        self._heads = heads
        self._answers = answers
        self._answer = next(answers, None)
        self._head = next(heads)
        self._target: Cell | None = None
        self.screen: PanelScreen | None = None
        self.fed: list[Pose] = []
        self.said: list[int] = []

    def before_frame(self) -> None:
        """Send the next state; give this to the headset as `before_wait`."""
        if self.screen is None or not self.screen.asking:
            self._head = next(self._heads, self._head)
        self._feed.send(RemoteState(self._head, right=self._hand()))
        self.fed.append(self._head)

    def watch(self, page: Page) -> None:
        """Choose the next target on a page that opens; give this to the `PanelRespondent`.

        Raises
        ------
        InputError
            If the script has too few answers, or one that the scale has not.
        """
        self._target = self._choice(page)

    def chose(self, cell: Cell) -> None:
        """Note that a choice has been taken; give this to the `PanelRespondent`, too."""
        if cell.act is Act.ANSWER:
            self.said.append(cell.value)
            self._answer = next(self._answers, None)
        self._target = None

    def _choice(self, page: Page) -> Cell:
        confirm = next((cell for cell in page.cells if cell.act is Act.CONFIRM), None)
        if confirm is not None:
            return confirm
        answer = self._answer
        cells = (cell for cell in page.cells if cell.act is Act.ANSWER and cell.value == answer)
        cell = next(cells, None)
        if cell is None:
            said = "has no more answers" if answer is None else f"answers {answer}"
            raise InputError(f"the script {said} at {page.question!r}; mend the script of answers")
        return cell

    def _hand(self) -> RemoteHand:
        quad = None if self.screen is None else self.screen.quad
        if quad is None or self._target is None:
            return RemoteHand(self._head @ Pose(np.array([0.2, -0.4, -0.3])))
        return RemoteHand(aim_at(quad, self._target.center), trigger=self._is_ready(self._target))

    def _is_ready(self, target: Cell) -> bool:
        """Return whether the session has seen the hand point at `target`, its button up."""
        if self.screen is None:
            return False
        seen = self.screen.pointing()
        return cell_at([target], seen.point) is target and not seen.held


def aim_at(quad: Quad, point: tuple[float, float]) -> Pose:
    """Return a hand before the panel that points at the fractions (right, down) of it."""
    width, height = quad.size_m
    target = np.array([(point[0] - 0.5) * width, (0.5 - point[1]) * height, 0.0])
    hand = np.array([0.1, -0.2, REACH_M])
    return quad.pose @ Pose(hand, turn_to(normalize(target - hand)))
