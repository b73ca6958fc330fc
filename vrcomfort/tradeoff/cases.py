"""What is looked at: a scene from a place on its walk, in some motion, with some effect."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Literal

from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.optics.circle_of_confusion import max_radius_px
from vrcomfort.protocol.conditions import Condition
from vrcomfort.tradeoff.methods import EFFECTS, LENSES, Effect, LensName, base_condition
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import MOTIONS, SCENES, Motion, pairs, slowly_later, with_motion
from vrcomfort.tradeoff.windows import HEADSET_PX, WINDOW_POSES, WINDOWS, Window, of_part, through


@dataclass(frozen=True)
class Scope:
    """How much is measured.

    Parameters
    ----------
    scenes, effects
        Which, in this order.
    motions
        With what moves during an exposure; without motion blur every scene is at rest.
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
    """One view with one effect: what a reference is drawn of."""

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
        """Return what files are called."""
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
        places = f"--poses {WINDOW_POSES}"
        raise InputError(f"--windows are parts of the places of {places}; give that")
    if scope.pose is not None and scope.pose >= scope.poses:
        raise InputError(f"--pose {scope.pose + 1}: there are {scope.poses}; give more --poses")
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
    """Return the condition whose reference all methods are compared with."""
    return condition_of(case, scope, base_condition(case.effect))


def eyes_of(case: Case, scope: Scope) -> Literal[1, 2]:
    """Return how many eyes are judged: of a window the left one, whose part of the image it is."""
    return 1 if case.window is not None else scope.eyes


def drawn_px(case: Case, scope: Scope) -> tuple[int, int]:
    """Return (width, height) of what is drawn."""
    return drawn(case, scope).size_px


def drawn(case: Case, scope: Scope) -> Window:
    """Return what is drawn: the whole image, or the case's window and as far as discs reach."""
    if case.window is None:
        return Window("whole", 0, 0, *scope.size_px)
    percent = LENSES[case.lens]["max_radius_percent"]
    reach_px = max_radius_px(percent, scope.size_px[0])
    return window_of(case).drawn(scope.size_px, reach_px)


def window_of(case: Case) -> Window:
    """Return the case's window, which it must have."""
    return next(each for each in WINDOWS[case.scene, case.pose] if each.name == case.window)


@cache
def _pairs(scene: str, size_px: tuple[int, int], count: int) -> list[tuple[Frame, Frame]]:
    return list(pairs(scene_and_hash(scene)[0], size_px, count))
