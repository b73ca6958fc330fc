"""Check of stimuli: how large blur and streaks are along a walk, and whether they can be seen.

Frames are drawn small, without a window: amounts are angles, and grow with the width of the image.
The measured radii and velocities are those that the effects themselves read, not a formula beside
them. Focus is where its rule finds it at that moment, as after the refocus law has arrived.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import atan, degrees
from typing import Any, TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import Frame
from vrcomfort.geometry import Gaze
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.conditions import Condition, DepthOfField
from vrcomfort.render.camera import HeadStep
from vrcomfort.render.condition_passes import EyeImages
from vrcomfort.render.effects.depth_of_field.coc_passes import DepthToCoc
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.effects.motion_blur import streak_scale
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene

Float32: TypeAlias = NDArray[np.float32]
Moment: TypeAlias = tuple[Frame, Frame]
"""A frame of a walk, and the one before it."""


@dataclass(frozen=True, eq=False)
class StimulusSize:
    """Blur and streaks of each pixel of the left eye in each frame sample.

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
        """Return the same in an image `factor` times as wide."""
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
    """Draw the frame samples small; return sizes by condition, in pixels of this image width.

    Conditions that find their focus and count their motion alike are drawn once.
    """
    found: dict[str, StimulusSize] = {}
    for probe, members in _probes(conditions):
        blurred = probe.depth_of_field is not None or probe.motion_blur is not None
        if not blurred:
            found |= {each.name: StimulusSize(None, None) for each in members}
            continue
        found |= _Walk(ctx, scene, probe, members, size_px).sizes(moments)
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


class _Walk:
    """Frame samples drawn under one probe, measured for all of its conditions."""

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
        self._focus = self._renderer.focus
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
                radii.see_with(images.camera)
                drawn.render()
                circles = 2 * np.abs(
                    np.asarray(read_texture(gl.of_eye(drawn.target, 0))[..., 3], np.float32)
                )
                self._circles[each.name].append(circles.ravel())
            if motion is not None:
                max_radius_px = motion.max_radius_percent / 50 * self._size_px[0]
                scale = motion.shutter_fraction * streak_scale(motion, step)
                velocity = np.zeros((*self._size_px[::-1], 2), np.float32)
                if images.velocity is not None:
                    velocity = np.asarray(read_texture(images.velocity), np.float32)[..., :2]
                length = np.hypot(velocity[..., 0], velocity[..., 1]) * np.float32(scale)
                self._streaks[each.name].append(np.minimum(length, max_radius_px).ravel())

    def _coc(
        self, condition: Condition, lens: DepthOfField, images: EyeImages
    ) -> tuple[DepthToCoc, FullscreenPass]:
        """Return the pass that draws a condition's radii, made when first asked for."""
        if condition.name not in self._radii:
            assert self._focus is not None  # noqa: S101 - tells mypy what `_take` knows
            reads = {"depth": images.depth, "focus": self._focus.texture}
            radii = DepthToCoc(
                EffectInputs(self._ctx, lens, images.pinhole, reads, condition.focus.infinity_m)
            )
            drawn = radii.make_pass(
                "depth_of_field/colour_and_coc.frag",
                size_px=self._size_px,
                inputs={"colour": images.pinhole},
                dtype="f4",
            )
            self._radii[condition.name] = radii, drawn
        return self._radii[condition.name]


def _looking_ahead(frame: Frame) -> Frame:
    """Return a frame with a gaze: straight ahead where none was recorded."""
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


LEAST_PX = 1.0
"""Smaller blur cannot be seen on the display: no pixel changes place."""
QUANTILE = 0.9
"""Share of the image that may be below."""


@dataclass(frozen=True)
class Amount:
    """Circles of confusion (diameter) or streaks (length) of a condition in a scene.

    Parameters
    ----------
    shown_percent
        Of the pixels, those where it is at least one pixel.
    """

    median_px: float
    p90_px: float
    median_arcmin: float
    p90_arcmin: float
    shown_percent: float


@dataclass(frozen=True)
class StimulusExtent:
    """Blur and streaks of a condition in a scene; None without such an effect."""

    condition: str
    scene: str
    circles: Amount | None
    streaks: Amount | None

    @property
    def p90_px(self) -> float:
        """Return the larger of the two."""
        return max((each.p90_px for each in (self.circles, self.streaks) if each), default=0.0)


def seen(condition: str, scene: str, size: StimulusSize, focal_px: float) -> StimulusExtent:
    """Return the amounts of a condition in a scene, in an image with this focal length."""
    parts = (size.circles_px, size.streaks_px)
    circles, streaks = (None if each is None else _amount(each, focal_px) for each in parts)
    return StimulusExtent(condition, scene, circles, streaks)


def _amount(values_px: Float32, focal_px: float) -> Amount:
    median, p90 = (float(each) for each in np.quantile(values_px, (0.5, QUANTILE)))
    return Amount(
        median,
        p90,
        arcmin_of(median, focal_px),
        arcmin_of(p90, focal_px),
        float((values_px >= LEAST_PX).mean() * 100),
    )


def arcmin_of(length_px: float, focal_px: float) -> float:
    """Return the angle of a length in the middle of an image."""
    return degrees(2 * atan(length_px / 2 / focal_px)) * 60


@dataclass(frozen=True)
class Fault:
    """A condition that cannot be seen, or two that cannot be told apart, in some scenes."""

    conditions: tuple[str, ...]
    scenes: tuple[str, ...]
    p90_px: float

    @property
    def message(self) -> str:
        """Return the fault as a sentence, with its remedy."""
        where = f"in {' and '.join(self.scenes)}"
        limit = f"nine tenths of the image have less than {max(self.p90_px, 0.01):.2f} px"
        if len(self.conditions) == 1:
            return (
                f"`{self.conditions[0]}` cannot be seen {where}: {limit} of blur or streak; make "
                "it stronger, or name it in [visibility] unseen if that is meant"
            )
        first, second = self.conditions
        return (
            f"`{first}` and `{second}` cannot be told apart {where}: {limit} between them; make "
            f'them differ, or write alike = [["{first}", "{second}"]] under [visibility]'
        )


def faults(protocol: Protocol, sizes: Mapping[str, Mapping[str, StimulusSize]]) -> Iterator[Fault]:
    """Yield conditions that cannot be seen or told apart, and are not meant so.

    Parameters
    ----------
    sizes
        By scene and condition, in the headset's pixels.
    """
    unseen = {
        each.name: [name for name in sizes if _p90(sizes[name][each.name]) < LEAST_PX]
        for each in protocol.conditions
        if _has_sizes(each) and not _others(each)
    }
    for name, scenes in unseen.items():
        if scenes and name not in protocol.visibility.unseen:
            largest = max(_p90(sizes[scene][name]) for scene in scenes)
            yield Fault((name,), tuple(scenes), largest)
    meant = {frozenset(pair) for pair in protocol.visibility.alike}
    for a, b in combinations(protocol.conditions, 2):
        if frozenset((a.name, b.name)) not in meant and _unmeasured(a) == _unmeasured(b):
            yield from _alike(a, b, sizes, unseen)


def _alike(
    a: Condition,
    b: Condition,
    sizes: Mapping[str, Mapping[str, StimulusSize]],
    unseen: Mapping[str, Sequence[str]],
) -> Iterator[Fault]:
    """Yield two conditions that look alike, but where one of them is nothing but unseen."""
    differences = {
        name: _difference_px(found[a.name], found[b.name])
        for name, found in sizes.items()
        if name not in unseen.get(a.name, ()) and name not in unseen.get(b.name, ())
    }
    scenes = tuple(name for name, each in differences.items() if each < LEAST_PX)
    if scenes:
        yield Fault((a.name, b.name), scenes, max(differences[name] for name in scenes))


def _has_sizes(condition: Condition) -> bool:
    return condition.depth_of_field is not None or condition.motion_blur is not None


def _others(condition: Condition) -> dict[str, Any]:
    """Return the settings of further blurs, which are not measured here."""
    measured = ("depth_of_field", "motion_blur")
    found: dict[str, Any] = {
        name: each for name, each in condition.effects.items() if name not in measured
    }
    if condition.background_blur is not None:
        found["background_blur"] = condition.background_blur
    return found


def _unmeasured(condition: Condition) -> dict[str, Any]:
    """Return the further blurs and gaze-contingent effects: sizes assume a gaze straight ahead."""
    centred = condition.centred_on_gaze
    return {**_others(condition), **({"gaze_centre": centred} if centred else {})}


def _p90(size: StimulusSize) -> float:
    parts = [each for each in (size.circles_px, size.streaks_px) if each is not None]
    return max((float(np.quantile(each, QUANTILE)) for each in parts), default=0.0)


def _difference_px(a: StimulusSize, b: StimulusSize) -> float:
    """Return the 90th percentile of the pixels' difference, of circles or streaks."""
    pairs = ((a.circles_px, b.circles_px), (a.streaks_px, b.streaks_px))
    found = [_apart(one, other) for one, other in pairs]
    return max(
        (float(np.quantile(each, QUANTILE)) for each in found if each is not None), default=0.0
    )


def _apart(a: Float32 | None, b: Float32 | None) -> Float32 | None:
    if a is None or b is None:
        return b if a is None else a
    apart: Float32 = np.abs(a - b)
    return apart


ALMOST, BY_TURNING = 0.7, 0.5
"""Streaks are told of that keep this share of `full`'s, and at most that share without turns."""


def turning_twins(conditions: Iterable[Condition]) -> Iterator[Condition]:
    """Yield, of each condition that cancels the head's turns alone, unasked, two others.

    One that cancels nothing, and one that cancels virtual turns, too, for `turning_left`.
    """
    for condition in conditions:
        motion = condition.motion_blur
        if motion is None or (motion.mode, motion.virtual_turning) != _HEAD_TURNS_ALONE:
            continue
        changes: dict[str, dict[str, Any]] = {
            "full": {"mode": "full", "neck": None},
            "cancelled": {"virtual_turning": "cancelled"},
        }
        for twin, change in changes.items():
            update = {
                "name": _twin(condition.name, twin),
                "motion_blur": motion.model_copy(update=change),
            }
            yield condition.model_copy(update=update)


_HEAD_TURNS_ALONE = ("rotation_cancelled", "by_mode")


def _twin(condition: str, twin: str) -> str:
    return f"{condition}, {twin}"  # no condition of a protocol can be called so


def turning_left(
    protocol: Protocol, sizes: Mapping[str, Mapping[str, StimulusSize]]
) -> Iterator[str]:
    """Yield a sentence for streaks that are almost those of `full`, and of virtual turns.

    Parameters
    ----------
    sizes
        By scene and condition, those of `turning_twins` among them.
    """
    for condition in protocol.conditions:
        for scene, found in sizes.items():
            if _twin(condition.name, "full") not in found:
                continue
            twins = (_twin(condition.name, each) for each in ("full", "cancelled"))
            left_px, full_px, rest_px = (
                _median_streak_px(found[name]) for name in (condition.name, *twins)
            )
            # Head and path may turn against each other: then `full` shows less, and says nothing.
            is_almost_full = min(left_px, full_px) >= LEAST_PX and left_px >= ALMOST * full_px
            if is_almost_full and rest_px <= BY_TURNING * left_px:
                yield (
                    f"`{condition.name}` leaves streaks of {left_px:.1f} px in {scene} (median), "
                    f"and {full_px:.1f} px with nothing cancelled: it keeps turns by stick or "
                    f'along a path. With virtual_turning = "cancelled" {rest_px:.1f} px are left; '
                    'write that, or "kept" if it is meant'
                )


def _median_streak_px(size: StimulusSize) -> float:
    return 0.0 if size.streaks_px is None else float(np.median(size.streaks_px))


def needlessly_meant(
    protocol: Protocol, sizes: Mapping[str, Mapping[str, StimulusSize]]
) -> Iterator[str]:
    """Yield a sentence for everything that [visibility] excuses and that needs no excuse."""
    for name in protocol.visibility.unseen:
        if all(_p90(found[name]) >= LEAST_PX for found in sizes.values()):
            yield f"`{name}` is in [visibility] unseen, and can be seen"
    for a, b in protocol.visibility.alike:
        if all(_difference_px(found[a], found[b]) >= LEAST_PX for found in sizes.values()):
            yield f"`{a}` and `{b}` are in [visibility] alike, and can be told apart"
