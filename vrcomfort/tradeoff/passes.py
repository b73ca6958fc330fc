"""The passes of a frame that are told apart, and a way to do something around each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.depth_of_field.lens_views import LensViews
from vrcomfort.render.effects.motion_blur.effect import MotionBlurPass
from vrcomfort.render.effects.speed_blur import SpeedBlurPass
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.render.tone_map import ToneMapPass

PASSES: dict[type[Any], str] = {
    ScenePass: "scene",
    LensViews: "lens_views",
    DepthOfFieldPass: "depth_of_field",
    MotionBlurPass: "motion_blur",
    SpeedBlurPass: "speed_blur",
    ToneMapPass: "tone_map",
    FullscreenPass: "other",
}
"""What is told apart: the outermost of these at any moment."""


@contextmanager
def outermost(
    around: Callable[[str, Callable[[], None]], None], owners: Mapping[type[Any], str]
) -> Iterator[None]:
    """Call `around` with the name and the drawing of each outermost pass that is drawn inside."""
    kept = [(owner, owner.render) for owner in owners]
    depth = [0]

    def wrapped(method: Callable[..., Any], name: str) -> Callable[..., Any]:
        def render(*arguments: Any, **options: Any) -> Any:
            if depth[0]:
                return method(*arguments, **options)
            depth[0] += 1
            found = []
            try:
                around(name, lambda: found.append(method(*arguments, **options)))
            finally:
                depth[0] -= 1
            return found[0]

        return render

    for owner, method in kept:
        owner.render = wrapped(method, owners[owner])
    try:
        yield
    finally:
        for owner, method in kept:
            owner.render = method
