"""Pixels off their median where all is wide blur, at a headset's size: ours, and the reference's.

``python -m bench.seams [--reference 1024]`` draws the left eye's image of one view of the temple
(1832×1920, fixed focus at 1.5 m, circles of 3.5 % of the width at 2 D) with each step of `samples`,
and counts as `vrcomfort.tradeoff.error_measures.off_median` does. With ``--reference`` it draws the
reference of each sixteenth of the image in which any step has such a pixel, too (half an hour on
one processor), and prints a line for each.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vrcomfort.api.rendering import make_renderer
from vrcomfort.frame import Frame
from vrcomfort.geometry import Array, Pose, View, yaw_pitch_roll
from vrcomfort.headset.playback import default_fovs
from vrcomfort.optics.circle_of_confusion import signed_radius_px
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus
from vrcomfort.render import output
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.condition_passes import EyeImages
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.brute_force import Reference
from vrcomfort.tradeoff.cases import HEADSET_PX, ImageWindow, of_part, sub_frustum
from vrcomfort.tradeoff.error_measures import OffMedian, off_median
from vrcomfort.tradeoff.methods import SAMPLES

HEAD = Pose((0.0734, 1.656, -6.3029), yaw_pitch_roll(*np.radians([-46.99, 6.11, 0.64])))
FOCUS_M, FULL_BLUR_DIOPTRE, PERCENT = 1.5, 2.0, 3.5
IPD_M, PERIOD_NS = 0.063, 11_111_111
PARTS = 4
"""Of the image's width, and of its height."""
MARGIN_PX = 8
"""What a part is drawn wider, for the medians at its border."""


class Drawn(NamedTuple):
    """The left eye's image of one step: display values and depths, top row first."""

    shown: Array
    depth: Array
    camera: EyeCamera


def main() -> None:
    """Read the command line, draw and print."""
    parser = argparse.ArgumentParser(prog="python -m bench.seams", description=__doc__)
    parser.add_argument("--reference", type=int, default=0, metavar="SAMPLES")
    options = parser.parse_args()
    scene, renderer = load_scene("temple"), make_renderer(HEADSET_PX)
    steps = {samples: _draw(renderer, scene, samples) for samples in SAMPLES}
    radius_px = _radius_px(steps[SAMPLES[0]])
    for samples, drawn in steps.items():
        _print(f"ours, {samples} samples", off_median(drawn.shown, radius_px))
    for row in range(PARTS if options.reference else 0):
        for column in range(PARTS):
            part = _slices(row, column)
            ours = [off_median(each.shown, radius_px, part).over_2 for each in steps.values()]
            if not any(ours):
                continue
            found = _reference(renderer, scene, steps[SAMPLES[0]].camera, part, options.reference)
            whole = steps[SAMPLES[0]].shown.copy()
            whole[_wider(part)] = found
            counts = ", ".join(map(str, ours))
            _print(f"row {row}, column {column}: ours {counts}; reference",
                   off_median(whole, radius_px, part))  # fmt: skip


def _condition(samples: int) -> Condition:
    lens = DepthOfField(
        law="dioptre",
        max_radius_percent=PERCENT,
        full_blur_dioptre=FULL_BLUR_DIOPTRE,
        samples=samples,
    )
    return Condition(
        name="seams", focus=Focus(method="fixed", fixed_m=FOCUS_M), depth_of_field=lens
    )


def _draw(renderer: StereoRenderer, scene: Scene, samples: int) -> Drawn:
    """Draw the view with a step of the dial."""
    half, (left, right) = np.array([IPD_M / 2, 0.0, 0.0]), default_fovs(HEADSET_PX)
    frame = Frame(
        index=1,
        predicted_display_time_ns=PERIOD_NS,
        period_ns=PERIOD_NS,
        head_pose=HEAD,
        views=(View(HEAD @ Pose(-half), left), View(HEAD @ Pose(half), right)),
        avatar_pose=Pose(),
        discontinuity=True,
    )
    found: list[Drawn] = []

    def keep(eye: int, images: EyeImages) -> None:
        if eye == 0:
            depth = output.read_depth(images.depth)
            found.append(
                Drawn(_shown(output.read_linear(images.linear), scene), depth, images.camera)
            )

    renderer.begin(scene, _condition(samples))
    renderer.render(frame, PERIOD_NS / 1e9, keep)
    return found[0]


def _shown(linear: Array, scene: Scene) -> Array:
    return np.asarray(tone_mapped(linear, exposure=scene.environment.exposure))


def _radius_px(drawn: Drawn) -> Array:
    """Return the radius of the circle of confusion of each pixel, in pixels of image width."""
    return np.abs(
        signed_radius_px(
            drawn.depth,
            law="dioptre",
            focus_m=FOCUS_M,
            near_m=drawn.camera.near_m,
            max_radius_px=HEADSET_PX[0] * PERCENT / 100,
            full_blur=FULL_BLUR_DIOPTRE,
        )
    )


def _slices(row: int, column: int) -> tuple[slice, slice]:
    (width, height) = (side // PARTS for side in HEADSET_PX)
    return (
        slice(row * height, (row + 1) * height),
        slice(column * width, (column + 1) * width),
    )


def _wider(part: tuple[slice, slice]) -> tuple[slice, slice]:
    """Return a part with its margin, where the image has one."""
    width, height = HEADSET_PX
    rows, columns = (
        slice(max(0, each.start - MARGIN_PX), min(side, each.stop + MARGIN_PX))
        for each, side in zip(part, (height, width), strict=True)
    )
    return rows, columns


def _reference(
    renderer: StereoRenderer,
    scene: Scene,
    camera: EyeCamera,
    part: tuple[slice, slice],
    samples: int,
) -> Array:
    """Draw a part of the image from points all over the lens; top row first."""
    rows, columns = _wider(part)
    window = ImageWindow(
        "part",
        columns.start,
        HEADSET_PX[1] - rows.stop,
        columns.stop - columns.start,
        rows.stop - rows.start,
    )
    condition = of_part(_condition(SAMPLES[0]), window.width_px / HEADSET_PX[0])
    reference = Reference(renderer.ctx, scene, condition, window.size_px)
    through = replace(camera, fov=sub_frustum(camera.fov, window, HEADSET_PX))
    sums = reference.render(through, PERIOD_NS / 1e9, None, focus_m=FOCUS_M, samples=samples)
    return _shown(sums.image[::-1].astype(np.float32), scene)


def _print(what: str, found: OffMedian) -> None:
    print(
        f"{what}: {found.over_2} off by more than 2/255, {found.over_4} by more than 4/255, "
        f"of {found.wide_px} pixels",
        flush=True,
    )


if __name__ == "__main__":
    main()
