"""How large the blur and the streaks of a condition are, pixel by pixel, along a walk.

Frames are drawn small, without a window: amounts are angles, and grow with the width of the image.
What is measured are the radii and velocities that the effects themselves read, not a formula beside
them. Focus is where its rule finds it at that moment, as after the refocus law has arrived.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias, cast

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import Frame
from vrcomfort.geometry import Gaze
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import Condition, DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import DepthToCoc
from vrcomfort.render.effects.motion_blur import streak_scale
from vrcomfort.render.focus.search import FocusPass
from vrcomfort.render.frames import EyeImages
from vrcomfort.render.head_step import HeadStep
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene

Float32: TypeAlias = NDArray[np.float32]
Moment: TypeAlias = tuple[Frame, Frame]
"""A frame of a walk, and the one before it."""


@dataclass(frozen=True, eq=False)
class StimulusSize:
    """What a condition does to each pixel of the left eye at each moment.

    Parameters
    ----------
    circles_px
        (n,) diameters of circles of confusion, None without depth of field.
    streaks_px
        (n,) lengths of streaks, None without motion blur.
    """

    circles_px: Float32 | None
    streaks_px: Float32 | None

    def scaled(self, factor: float) -> StimulusSize:
        """Return the same in an image so many times as wide."""
        parts = (self.circles_px, self.streaks_px)
        circles, streaks = (None if each is None else each * np.float32(factor) for each in parts)
        return StimulusSize(circles, streaks)


def measure(
    ctx: moderngl.Context,
    scene: Scene,
    conditions: Iterable[Condition],
    moments: Sequence[Moment],
    size_px: tuple[int, int],
) -> dict[str, StimulusSize]:
    """Draw the moments small; return condition → what it does, in pixels of an image of this width.

    Conditions that find their focus and count their motion alike are drawn once.
    """
    found: dict[str, StimulusSize] = {}
    for probe, members in _probes(conditions):
        blurred = probe.depth_of_field is not None or probe.motion_blur is not None
        if not blurred:
            found |= {each.name: StimulusSize(None, None) for each in members}
            continue
        found |= _Drawn(ctx, scene, probe, members, size_px).sizes(moments)
    return found


def _probes(conditions: Iterable[Condition]) -> Iterator[tuple[Condition, list[Condition]]]:
    """Yield the cheapest condition that finds focus and velocity as some conditions do."""
    alike: list[tuple[Condition, list[Condition]]] = []
    for condition in conditions:
        probe = _probe(condition)
        members = next((members for other, members in alike if other == probe), None)
        if members is None:
            alike.append((probe, [condition]))
        else:
            members.append(condition)
    yield from alike


def _probe(condition: Condition) -> Condition:
    lens, motion = condition.depth_of_field, condition.motion_blur
    settings: dict[str, Any] = {}
    if lens is not None:
        settings["focus"] = condition.focus
        settings["depth_of_field"] = DepthOfField(distance_along=lens.distance_along, samples=16)
    if motion is not None:
        same = {"shutter_fraction": 0.5, "max_radius_percent": 5.0, "fade_with_turning": None}
        settings["motion_blur"] = motion.model_copy(update=same)
    return Condition(name="probe", **settings)


class _Drawn:
    """The moments under one probe, and what its conditions make of them."""

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        probe: Condition,
        members: list[Condition],
        size_px: tuple[int, int],
    ) -> None:
        self._ctx, self._members, self._size_px = ctx, members, size_px
        self._renderer = StereoRenderer(ctx, size_px, eyes=1, samples=1)
        self._renderer.build(scene, probe)
        self._focus = cast(FocusPass | None, dict(self._renderer.parts()).get("focus"))
        self._radii: dict[str, tuple[DepthToCoc, FullscreenPass]] = {}
        self._circles: dict[str, list[Float32]] = {each.name: [] for each in members}
        self._streaks: dict[str, list[Float32]] = {each.name: [] for each in members}

    def sizes(self, moments: Sequence[Moment]) -> dict[str, StimulusSize]:
        """Draw all moments, and return condition → its amounts."""
        for moment in moments:
            before, now = (_looking_ahead(frame) for frame in moment)
            self._renderer.render(replace(before, discontinuity=True), _time_s(before))
            take = partial(self._take, step_between(before, now))
            self._renderer.render(replace(now, discontinuity=False), _time_s(now), take)
        self._renderer.release()
        return {
            each.name: StimulusSize(
                _joined(self._circles[each.name]), _joined(self._streaks[each.name])
            )
            for each in self._members
        }

    def _take(self, step: HeadStep, _eye: int, images: EyeImages) -> None:
        for each in self._members:
            lens, motion = each.depth_of_field, each.motion_blur
            if lens is not None and self._focus is not None:
                radii, drawn = self._coc(each, lens, images)
                drawn.render(radii.of_camera(images.camera))
                circles = 2 * np.abs(np.asarray(read_texture(drawn.target)[..., 3], np.float32))
                self._circles[each.name].append(circles.ravel())
            if motion is not None:
                limit_px = motion.max_radius_percent / 50 * self._size_px[0]
                scale = motion.shutter_fraction * streak_scale(motion, step)
                velocity = np.zeros((*self._size_px[::-1], 2), np.float32)
                if images.velocity is not None:
                    velocity = np.asarray(read_texture(images.velocity), np.float32)[..., :2]
                length = np.hypot(velocity[..., 0], velocity[..., 1]) * np.float32(scale)
                self._streaks[each.name].append(np.minimum(length, limit_px).ravel())

    def _coc(
        self, condition: Condition, lens: DepthOfField, images: EyeImages
    ) -> tuple[DepthToCoc, FullscreenPass]:
        """Return what draws the radii of a condition, made when first asked for."""
        if condition.name not in self._radii:
            assert self._focus is not None  # noqa: S101 - tells mypy what `_take` knows
            radii = DepthToCoc(
                depth=images.depth,
                focus=self._focus.texture,
                settings=lens,
                infinity_m=condition.focus.infinity_m,
            )
            drawn = radii.make_pass(
                self._ctx,
                "depth_of_field/colour_and_coc.frag",
                size_px=self._size_px,
                inputs={"colour": images.pinhole},
                dtype="f4",
            )
            self._radii[condition.name] = radii, drawn
        return self._radii[condition.name]


def _looking_ahead(frame: Frame) -> Frame:
    """Return a frame with a gaze: straight ahead where nobody's was recorded."""
    return frame if frame.gaze is not None else replace(frame, gaze=Gaze(frame.head_pose))


def _time_s(frame: Frame) -> float:
    return frame.predicted_display_time_ns / 1e9


def step_between(before: Frame, now: Frame) -> HeadStep:
    """Return how the head got from one frame of a walk to the next."""
    seconds = (now.predicted_display_time_ns - before.predicted_display_time_ns) / 1e9
    return HeadStep(
        before.head_pose, now.head_pose, before.avatar_pose, now.avatar_pose, seconds=seconds
    )


def _joined(parts: list[Float32]) -> Float32 | None:
    return np.concatenate(parts) if parts else None
