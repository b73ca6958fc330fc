"""Puts the participant's panel into a headset: its place in the room, and pointing at it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Protocol

import numpy as np

from vrcomfort.errors import headset_ended
from vrcomfort.frame import Frame, HeadsetEvent
from vrcomfort.geometry import Pose, Quad, heading
from vrcomfort.headset.base import HasHaptics, HasInputs
from vrcomfort.headset.inputs import Inputs, pointer_quad
from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.respondent.panel_input import Pointing
from vrcomfort.respondent.panel_layout import SIZE_PX
from vrcomfort.respondent.panel_picture import Page, Painter, Picture

DISTANCE_M = 1.25
WIDTH_M = 1.04
"""45 degrees wide at its distance."""
DROP_M = 0.1
"""A little below the eyes, where reading tires less."""
LOADING_FRAMES = 10
"""Limit of frames for loading, while nothing is shown."""


class Panel(Protocol):
    """A picture on a rectangle that stands in the room."""

    quad: Quad

    def draw(self, picture: Picture) -> None:
        """Show a picture."""

    def hide(self) -> None:
        """Take the panel away."""


class PanelHeadset(HasInputs, HasHaptics, Protocol):
    """A headset in which questions can be asked."""

    @property
    def head_pose(self) -> Pose:
        """Return stage-from-head of the last frame."""

    def frames(self) -> Iterator[Frame]:
        """Yield frames."""

    def submit(self, frame: Frame, eyes: None) -> None:
        """Show the panels alone."""

    def take_events(self) -> list[HeadsetEvent]:
        """Return the events since the last call."""

    def allow_absence(self, duration_s: float) -> None:
        """Expect no looks for a duration: the headset may be taken off."""

    def show_panel(self, size_px: tuple[int, int], quad: Quad) -> Panel:
        """Put a panel into the room."""

    def show_pointer(self, quad: Quad | None) -> None:
        """Put the pointer there, in front of all panels, or take it away."""


class PanelScreen:
    """A panel that appears before the participant, and then stays where it is.

    Parameters
    ----------
    words
        In the participant's language.
    points_with_head
        Where neither a controller nor the eyes are seen, the middle of the head's view points.

    Attributes
    ----------
    notice
        Called with what happens to the headset while a question is open; None leaves it to others.
    each_frame
        Called before each frame that passes while a question is open.
    """

    def __init__(
        self, headset: PanelHeadset, *, words: Words = ENGLISH, points_with_head: bool = False
    ) -> None:
        self._headset = headset
        self._words = words
        self._points_with_head = points_with_head
        self._frames: Iterator[Frame] | None = None
        self._panel: Panel | None = None
        self._picture: Picture | None = None
        self._hand = 1
        self._resting: Picture | None = None
        self.notice: Callable[[HeadsetEvent], None] | None = None
        self.each_frame: Callable[[], None] = lambda: None

    @property
    def quad(self) -> Quad | None:
        """Return where the panel stands, or None while there is none."""
        return None if self._panel is None else self._panel.quad

    @property
    def asking(self) -> bool:
        """Return whether a question is open that the session waits for."""
        return self._frames is not None

    def rest_on(self, words: str | None) -> None:
        """Show words wherever nothing else is shown, or no longer."""
        picture = None if words is None else words_picture(words)
        if picture is self._resting:
            return
        nothing_else = self._picture is self._resting
        self._resting = picture
        if nothing_else:
            self.show(None)

    def show(self, picture: Picture | None) -> None:
        """Show a picture, or take the panel away."""
        picture = self._resting if picture is None else picture
        self._picture = picture
        if picture is not None:
            if self._panel is None:
                self._panel = self._headset.show_panel(SIZE_PX, before(self._headset.head_pose))
            self._panel.draw(picture)
        elif self._panel is not None:
            self._headset.show_pointer(None)
            self._panel.hide()
            self._panel = self._frames = None

    def point_at(self, point: tuple[float, float] | None) -> None:
        """Put the pointer at fractions (right, down) of the panel, or take it away."""
        if point is None or self._panel is None:
            self._headset.show_pointer(None)
        else:
            self._headset.show_pointer(pointer_quad(self._panel.quad, point))

    def pointing(self) -> Pointing:
        """Return the pointing of a controller, else of eyes, else of the head; and the keys.

        Of two controllers that point at the panel, the one that presses counts, else the one that
        pressed last.
        """
        inputs = self._headset.inputs()
        keys, look = inputs.keys, self._look(inputs)
        return replace(
            self._pointed(inputs),
            down_deg=float(np.degrees(np.arcsin(np.clip(-look.forward[1], -1.0, 1.0)))),
            looked=self._hit(look),
            back=inputs.back,
            stop=inputs.stop,
            fist=any(hand.fist for hand in inputs.hands),
            arrow=keys.arrow,
            digits=keys.digits,
            letters=keys.letters,
            enter=keys.enter,
        )

    def _pointed(self, inputs: Inputs) -> Pointing:
        hands = inputs.hands
        for number in sorted((self._hand, 1 - self._hand), key=lambda n: not hands[n].select):
            point, hand = self._hit(hands[number].aim), hands[number]
            if point is not None:
                self._hand = number if hand.select else self._hand
                return Pointing(point, hand.select, held=hand.held, hand=number)
        gaze = inputs.gaze
        point = self._hit(gaze.pose) if gaze is not None and gaze.valid else None
        seen = any(hand.aim for hand in hands) or (gaze is not None and gaze.valid)
        if not seen and gaze is None and self._points_with_head:
            return Pointing(self._hit(self._headset.head_pose), dwelling=True)
        return Pointing(point, dwelling=point is not None, unable=not seen)

    def _look(self, inputs: Inputs) -> Pose:
        """Return the look that may ask to stop: the eyes', or else the head's."""
        gaze = inputs.gaze
        return gaze.pose if gaze is not None and gaze.valid else self._headset.head_pose

    def show_loading(self) -> None:
        """Show that something is being loaded: runtimes show the last frame until another comes."""
        self.show(words_picture(self._words.loading))
        for _ in range(LOADING_FRAMES):
            panel, frame = self._panel, self._pass_frame()
            if frame.should_render and panel is self._panel:
                break
        self.show(None)

    def next_frame(self) -> None:
        """Let a frame pass that shows the panel alone.

        Raises
        ------
        RuntimeLostError
            If the headset ends the session while a question is open. And what `each_frame` raises.
        """
        self.each_frame()
        self._pass_frame()

    def _pass_frame(self) -> Frame:
        if self._frames is None:
            self._frames = self._headset.frames()
        frame = next(self._frames, None)
        if frame is None:
            raise headset_ended("while a question was open")
        self._headset.submit(frame, None)
        if self.notice is not None:
            self._tell(self.notice)
        return frame

    def allow_absence(self, duration_s: float) -> None:
        """Let the participant take the headset off for a duration."""
        self._headset.allow_absence(duration_s)

    def tick(self, hand: int) -> None:
        """Confirm an answer to the hand that gave it."""
        self._headset.tick(hand)

    def _tell(self, notice: Callable[[HeadsetEvent], None]) -> None:
        for event in self._headset.take_events():
            notice(event)
            if event.name in {"recentered", "head_found"}:  # where it stands means nothing now
                self._place_again()

    def _place_again(self) -> None:
        """Put the panel before the participant again, after a recentring."""
        if self._panel is not None:
            self._panel.hide()
            self._panel = None
            self.show(self._picture)

    def _hit(self, ray: Pose | None) -> tuple[float, float] | None:
        return None if ray is None or self._panel is None else self._panel.quad.intersection(ray)


def before(head: Pose) -> Quad:
    """Return an upright panel before a head, at reading height."""
    level = Pose(head.position, heading(head))
    place = level @ Pose(np.array([0.0, -DROP_M, -DISTANCE_M]))
    return Quad(place, (WIDTH_M, WIDTH_M * SIZE_PX[1] / SIZE_PX[0]))


@lru_cache(maxsize=16)
def words_picture(words: str) -> Picture:
    """Return a panel with nothing but words on it."""
    return Painter().draw(Page("", words, ()), None)
