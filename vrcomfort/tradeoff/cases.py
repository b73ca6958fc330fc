"""Cases: a scene from a place on its walk, in some motion, with some effect, or a window of it.

At a headset's size a reference of the whole image takes too long without a GPU. A window is drawn
with a frustum of its own, on the pixel grid of the whole image, and wider than the judged part: by
as far as any disc reaches. Its corner is a multiple of :data:`ALIGNED_PX`, so that tiles and
half-resolution texels lie where they would lie in the whole image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Literal

from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, View
from vrcomfort.optics.circle_of_confusion import radius_of_percent
from vrcomfort.protocol.conditions import Condition
from vrcomfort.tradeoff.methods import EFFECTS, LENSES, Effect, LensName, base_condition
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import MOTIONS, SCENES, Motion, pairs, slowly_later, with_motion

ALIGNED_PX = 32
"""Side of the widest tile (and of a texel of the coarsest mip level) that is kept in place."""

SLACK_PX = 16
"""How much farther than the widest disc a method may look: half a tile, or a bilinear read."""

HEADSET_PX = (1832, 1920)
"""The whole image that the windows of :data:`WINDOWS` are parts of."""

WINDOW_POSES = 2
"""Places of each walk, of which :data:`WINDOWS` has parts."""


@dataclass(frozen=True)
class ImageWindow:
    """A rectangle of a whole image, in pixels from its lower left corner.

    Parameters
    ----------
    name
        Named by its content.
    left_px, bottom_px, width_px, height_px
        The judged part.
    """

    name: str
    left_px: int
    bottom_px: int
    width_px: int
    height_px: int

    def drawn(self, whole_px: tuple[int, int], reach_px: float) -> ImageWindow:
        """Return the window that is drawn: the judged part and everything up to `reach_px` away.

        It ends where the whole image ends: no post-process sees anything outside.
        """
        wider = math.ceil((reach_px + SLACK_PX) / ALIGNED_PX) * ALIGNED_PX
        left, bottom = max(0, self.left_px - wider), max(0, self.bottom_px - wider)
        right = min(whole_px[0], self.left_px + self.width_px + wider)
        top = min(whole_px[1], self.bottom_px + self.height_px + wider)
        return replace(
            self, left_px=left, bottom_px=bottom, width_px=right - left, height_px=top - bottom
        )

    @property
    def size_px(self) -> tuple[int, int]:
        """Return (width, height)."""
        return self.width_px, self.height_px

    def within(self, other: ImageWindow) -> tuple[slice, slice]:
        """Return where it lies in images of another window: slices of rows and of columns."""
        left, bottom = self.left_px - other.left_px, self.bottom_px - other.bottom_px
        return slice(bottom, bottom + self.height_px), slice(left, left + self.width_px)


WINDOWS: dict[tuple[str, int], tuple[ImageWindow, ...]] = {
    ("temple", 0): (
        ImageWindow("near_rims", 224, 1056, 448, 448),
        ImageWindow("far_edges", 1216, 608, 616, 512),
    ),
    ("temple", 1): (ImageWindow("lamps", 512, 768, 448, 448),),
    ("mountain", 0): (
        ImageWindow("near_rims", 64, 1440, 448, 448),
        ImageWindow("thin", 1152, 1056, 448, 448),
    ),
    ("mountain", 1): (),
}
"""By scene and place on its walk, parts of the left eye's image of :data:`HEADSET_PX`: blurred
foreground over background, far edges up to the image's border, lamps, thin objects."""


def through(frame: Frame, window: ImageWindow, whole_px: tuple[int, int]) -> Frame:
    """Return the frame with frusta that see only the window, in both eyes."""
    left, right = (View(view.pose, sub_frustum(view.fov, window, whole_px)) for view in frame.views)
    return replace(frame, views=(left, right))


def sub_frustum(fov: Fov, window: ImageWindow, whole_px: tuple[int, int]) -> Fov:
    """Return the frustum of a part of an image: tangents are linear in pixels."""
    left, right, up, down = fov.tangents
    wide, tall = (right - left) / whole_px[0], (up - down) / whole_px[1]
    return Fov(
        math.atan(left + window.left_px * wide),
        math.atan(left + (window.left_px + window.width_px) * wide),
        math.atan(down + (window.bottom_px + window.height_px) * tall),
        math.atan(down + window.bottom_px * tall),
    )


def of_part(condition: Condition, part: float) -> Condition:
    """Return the condition that blurs an image by as many pixels as one `part` times as wide.

    Percentages of the image's width grow, beyond what a protocol may ask for.
    """
    changes = {}
    for name in ("depth_of_field", "motion_blur"):
        settings = getattr(condition, name)
        if settings is not None:
            percent = settings.max_radius_percent / part
            changes[name] = settings.model_copy(update={"max_radius_percent": percent})
    return condition.model_copy(update=changes)


@dataclass(frozen=True)
class Scope:
    """How much is measured.

    Parameters
    ----------
    scenes, effects
        Which, in this order.
    motions
        Motion during an exposure; without motion blur every scene is at rest.
    poses
        Places on each scene's walk.
    pose
        Only this one of them, from 0; None for all.
    size_px
        (width, height) of one eye's image.
    samples
        Of each reference with a lens; a shutter alone (one dimension) takes a quarter.
    quick
        Fewer steps of each dial.
    methods
        Only these (and no blur); None for all.
    rounds
        Timed frames of each method; None for as many as the device is given.
    lenses
        How wide the lens is, one case each; without depth of field only the first.
    windows
        Whether parts of the image are judged in place of the whole: those of `WINDOWS`, left eye.
    eyes
        1 judges the left eye alone: nothing is known of binocular errors then.
    flicker
        Whether it is found how errors change until a frame later: twice as many references.
    """

    scenes: tuple[str, ...] = SCENES
    effects: tuple[Effect, ...] = EFFECTS
    motions: tuple[Motion, ...] = MOTIONS[1:]
    poses: int = 2
    pose: int | None = None
    size_px: tuple[int, int] = (320, 400)
    samples: int = 2048
    quick: bool = False
    methods: tuple[str, ...] | None = None
    rounds: int | None = None
    lenses: tuple[LensName, ...] = ("3.5",)
    windows: bool = False
    eyes: Literal[1, 2] = 2
    flicker: bool = False


@dataclass(frozen=True)
class Case:
    """One view with one effect; each has a reference."""

    scene: str
    pose: int
    motion: Motion
    effect: Effect
    lens: LensName = "3.5"
    window: str | None = None
    """Name of the part of the image that is judged; None for all of it."""
    later: bool = False
    """A frame of slow walking later, of which only flicker is found."""

    @property
    def name(self) -> str:
        """Return the stem of the case's files."""
        parts = [self.scene, self.effect, f"pose{self.pose + 1}", self.motion]
        parts += [f"lens{self.lens}"] if self.effect != "motion_blur" else []
        return "_".join([*parts, *([self.window] if self.window else [])])


def samples_of(case: Case, scope: Scope) -> int:
    """Return the samples of a case's reference."""
    return scope.samples if case.effect != "motion_blur" else max(2, scope.samples // 4)


def cases(scope: Scope) -> list[Case]:
    """Return all cases; depth of field alone sees no motion, motion blur alone no lens.

    Raises
    ------
    InputError
        If windows are asked for at a size that they are not made for, or a place that there is not.
    """
    if scope.windows and scope.size_px != HEADSET_PX:
        width, height = HEADSET_PX
        raise InputError(f"--windows are parts of images of {width}x{height}; give that --size")
    if scope.windows and scope.poses != WINDOW_POSES:
        places = f"--views {WINDOW_POSES}"
        raise InputError(f"--windows are parts of the places of {places}; give that")
    if scope.pose is not None and scope.pose >= scope.poses:
        raise InputError(f"--view {scope.pose + 1}: there are {scope.poses}; give more --views")
    poses = range(scope.poses) if scope.pose is None else (scope.pose,)
    found = product(scope.scenes, scope.effects, poses)
    made = [
        Case(scene, pose, motion, effect, lens, window)
        for scene, effect, pose in found
        for motion in (("still",) if effect == "depth_of_field" else scope.motions)
        for lens in (scope.lenses[:1] if effect == "motion_blur" else scope.lenses)
        for window in _window_names(scene, pose, scope)
    ]
    if not made:
        raise InputError("--windows: that place of the walk has none; choose another --pose")
    return made


def _window_names(scene: str, pose: int, scope: Scope) -> tuple[str | None, ...]:
    if not scope.windows:
        return (None,)
    return tuple(window.name for window in WINDOWS.get((scene, pose), ()))


def frames(case: Case, scope: Scope) -> tuple[Frame, Frame]:
    """Return the frame before and the frame to look at, through the case's window."""
    pair = _pairs(case.scene, scope.size_px, scope.poses)[case.pose]
    before, frame = with_motion(pair, case.motion)
    if case.later:
        before, frame = slowly_later(before), slowly_later(frame)
    if case.window is None:
        return before, frame
    window = drawn(case, scope)
    return through(before, window, scope.size_px), through(frame, window, scope.size_px)


def condition_of(case: Case, scope: Scope, condition: Condition) -> Condition:
    """Return a method's condition with the case's lens, for the image that is drawn."""
    if condition.depth_of_field is not None:
        lens = condition.depth_of_field.model_copy(update=LENSES[case.lens])
        condition = condition.model_copy(update={"depth_of_field": lens})
    return of_part(condition, drawn_px(case, scope)[0] / scope.size_px[0])


def reference_condition(case: Case, scope: Scope) -> Condition:
    """Return the condition of the reference for all methods."""
    return condition_of(case, scope, base_condition(case.effect))


def eyes_of(case: Case, scope: Scope) -> Literal[1, 2]:
    """Return how many eyes are judged: of a window the left one alone."""
    return 1 if case.window is not None else scope.eyes


def drawn_px(case: Case, scope: Scope) -> tuple[int, int]:
    """Return (width, height) of the drawn image."""
    return drawn(case, scope).size_px


def drawn(case: Case, scope: Scope) -> ImageWindow:
    """Return the drawn window: the whole image, or the case's window and as far as discs reach."""
    if case.window is None:
        return ImageWindow("whole", 0, 0, *scope.size_px)
    percent = LENSES[case.lens]["max_radius_percent"]
    reach_px = radius_of_percent(percent, scope.size_px[0])
    return window_of(case).drawn(scope.size_px, reach_px)


def window_of(case: Case) -> ImageWindow:
    """Return the case's window, which it must have."""
    return next(each for each in WINDOWS[case.scene, case.pose] if each.name == case.window)


@cache
def _pairs(scene: str, size_px: tuple[int, int], count: int) -> list[tuple[Frame, Frame]]:
    return list(pairs(scene_and_hash(scene)[0], size_px, count))
