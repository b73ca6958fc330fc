"""What is looked at: a scene from a place on its walk, in some motion, with some effect."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product

from vrcomfort.frame import Frame
from vrcomfort.tradeoff.methods import EFFECTS, Effect
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import MOTIONS, SCENES, Motion, pairs, with_motion


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
    """

    scenes: tuple[str, ...] = SCENES
    effects: tuple[Effect, ...] = EFFECTS
    motions: tuple[Motion, ...] = MOTIONS[1:]
    poses: int = 2
    size_px: tuple[int, int] = (320, 400)
    samples: int = 2048
    quick: bool = False
    methods: tuple[str, ...] | None = None
    rounds: int | None = None


@dataclass(frozen=True)
class Case:
    """One view with one effect: what a reference is drawn of."""

    scene: str
    pose: int
    motion: Motion
    effect: Effect

    @property
    def name(self) -> str:
        """Return what files are called."""
        return f"{self.scene}_{self.effect}_pose{self.pose + 1}_{self.motion}"


def samples_of(case: Case, scope: Scope) -> int:
    """Return the samples of a case's reference."""
    return scope.samples if case.effect != "motion_blur" else max(2, scope.samples // 4)


def cases(scope: Scope) -> list[Case]:
    """Return all cases; depth of field alone sees no motion."""
    found = product(scope.scenes, scope.effects, range(scope.poses))
    return [
        Case(scene, pose, motion, effect)
        for scene, effect, pose in found
        for motion in (("still",) if effect == "depth_of_field" else scope.motions)
    ]


def frames(case: Case, scope: Scope) -> tuple[Frame, Frame]:
    """Return the frame before and the frame to look at."""
    return with_motion(_pairs(case.scene, scope.size_px, scope.poses)[case.pose], case.motion)


@cache
def _pairs(scene: str, size_px: tuple[int, int], count: int) -> list[tuple[Frame, Frame]]:
    return list(pairs(scene_and_hash(scene)[0], size_px, count))
