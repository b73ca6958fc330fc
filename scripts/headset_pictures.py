"""Makes the documentation's pictures of questions in a headset.

Run ``scripts/in_runtime.sh python scripts/headset_pictures.py docs/images``: a session in a Monado
runtime, whose left eye is drawn with the panel before it as the operator's mirror draws it, at
16 pixels per degree in the middle.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path

import moderngl
from PIL import Image

from vrcomfort.api.views import DEFAULT_CONDITION
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose
from vrcomfort.gpu.gl import create_context
from vrcomfort.headset.eye_painter import EyePainter, WindowPanel
from vrcomfort.headset.inputs import KeyInput
from vrcomfort.headset.monado import Monado, RemoteFeed, RemoteHand, RemoteState
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.openxr.layers import Eyes, PanelLayer
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.render.output import read_rgb8
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.respondent.base import Form
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_picture import Page
from vrcomfort.scene.load import load_scene
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import aim_at

FMS = shipped_instruments()["fms"]
SSQ = shipped_instruments()["ssq"]

SIZE_PX = 1536, 1536
SHOWN = slice(180, 1356), slice(0, 1536)
"""Rows and columns of the pictures: the middle of the view."""

HEAD = Pose((0.0, 1.6, 0.0))
FRAMES = 8


class View:
    """Stands in for the operator's window: keeps what it would show."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._painter = EyePainter(ctx)
        self._target = ctx.framebuffer([ctx.texture(SIZE_PX, 4)])

    def keys(self) -> KeyInput:
        """Return no keys."""
        return KeyInput()

    def show(self, frame: Frame, eyes: Eyes | None, panels: Sequence[PanelLayer]) -> None:
        """Draw the left eye."""
        self._target.clear()
        copies = []
        for panel in panels:
            if panel.picture is not None:
                copies.append(WindowPanel(self._ctx, panel.size_px, panel.quad))
                copies[-1].draw(panel.picture)
        image = None if eyes is None else eyes[0]
        self._painter.paint(self._target, (0, 0, *SIZE_PX), image, frame.views[0], copies)

    def save(self, file: Path) -> None:
        """Write what was shown last."""
        pixels = read_rgb8(self._target.color_attachments[0])[SHOWN]
        Image.fromarray(pixels).save(file, quality=88)


class Participant:
    """Points at one cell of each page, and never presses."""

    def __init__(self, feed: RemoteFeed) -> None:
        self._feed = feed
        self._point: tuple[float, float] | None = None
        self._frames_left: int | None = None
        self.screen: PanelScreen | None = None

    def watch(self, page: Page) -> None:
        """Point at the third cell, a little beside its middle."""
        right, down = page.cells[2].center
        self._point = right + 0.03, down + 0.04

    def leave_after(self, frames: int) -> None:
        """Raise `Enough` then."""
        self._frames_left = frames

    def before_frame(self) -> None:
        """Send head and hand."""
        if self._frames_left is not None:
            self._frames_left -= 1
            if self._frames_left < 0:
                raise Enough
        quad = self.screen.quad if self.screen else None
        pose = HEAD if quad is None or self._point is None else aim_at(quad, self._point)
        self._feed.send(RemoteState(HEAD, right=RemoteHand(pose)))


class Enough(Exception):  # noqa: N818 - not an error
    """The picture is there."""


def _main(folder: Path) -> None:
    ctx = create_context()
    scene = load_scene("temple")
    view = View(ctx)
    with Monado() as monado, monado.feed() as feed:
        hand = Participant(feed)
        settings = OpenXrSettings(image_size_px=SIZE_PX)
        with OpenXrHeadset(ctx, settings, before_wait=hand.before_frame, window=view) as headset:
            hand.screen = PanelScreen(headset)
            person = PanelRespondent(hand.screen, watch=hand.watch)
            renderer = StereoRenderer(ctx, SIZE_PX)
            renderer.begin(scene, DEFAULT_CONDITION)
            headset.place(spawn=scene.spawn)
            list(islice(headset.frames(), 6))
            person.prompt(FMS, 0.0, 60.0)
            for number, frame in enumerate(islice(headset.frames(), FRAMES)):
                headset.submit(frame, renderer.render(frame, number / 20).eyes)
                person.endure(number / 20)
            view.save(folder / "headset_rating.jpg")
            person.end_exposure(1.0)
            hand.leave_after(FRAMES)
            with suppress(Enough):
                person.ask(Form(SSQ, "baseline"), lambda *_: None)
            view.save(folder / "headset_question.png")
            hand.leave_after(1000)


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
