"""One stereo picture, its numbers, and (if asked) its ground truth and error."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from vrcomfort.cli.renderer import make_renderer
from vrcomfort.cli.terminal import console, progress_bar, warn
from vrcomfort.errors import InputError
from vrcomfort.frame import EYE_HEIGHT_M
from vrcomfort.geometry import FARTHEST_M, Pose, View, yaw_pitch_roll
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.protocol import Condition

if TYPE_CHECKING:
    from vrcomfort.frame import Frame
    from vrcomfort.render.condition_passes import EyeImages
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.scene.data import Scene

PERIOD_NS = 11_111_111
"""One frame at 90 Hz between the previous pose and this one."""

EYES = ("left", "right")

Advance: TypeAlias = Callable[..., None]
"""Takes steps that are done, and what begins."""


@dataclass(frozen=True)
class PoseText:
    """A pose as it was typed, and the option it came from."""

    option: str
    text: str | None = None

    def pose(self) -> Pose | None:
        """Return world-from-head, or None where nothing was typed.

        Raises
        ------
        InputError
            If it is not six numbers.
        """
        if self.text is None:
            return None
        parts = self.text.split(",")
        try:
            numbers = [float(part) for part in parts]
        except ValueError:
            numbers = []
        if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
            raise InputError(
                f"{self.option} {self.text!r} is not a pose; write X,Y,Z,YAW,PITCH,ROLL "
                "in metres and degrees, for example 0,1.6,0,30,-5,0"
            )
        if max(map(abs, numbers[:3])) > FARTHEST_M:
            raise InputError(
                f"{self.option} {self.text!r} is more than {FARTHEST_M / 1e3:.0f} km from the "
                "scene's origin; positions are metres"
            )
        return Pose(np.array(numbers[:3]), yaw_pitch_roll(*np.radians(numbers[3:])))


def still(
    scene_source: str,
    condition: Condition,
    *,
    poses: tuple[PoseText, PoseText],
    size_px: tuple[int, int],
    ipd_m: float,
    out: Path,
    reference_samples: int = 0,
    quiet: bool = False,
) -> Path:
    """Draw a stereo picture into `out`; return the side-by-side image's path.

    Parameters
    ----------
    poses
        The head now and one frame before.
    reference_samples
        Draw the ground truth with so many samples; 0 does not.
    """
    from vrcomfort.render.image_error import margin_px

    now, before = (each.pose() for each in poses)
    if reference_samples:
        margin_px(size_px)  # refuses what is all margin before anything is drawn
    steps = 2 * (1 + reference_samples + bool(reference_samples))
    with progress_bar("loading", steps, quiet=quiet, unit="steps") as advance:
        picture, errors = _draw(
            scene_source, condition, (now, before), size_px, ipd_m, out, reference_samples, advance
        )
    for name in EYES if errors else ():
        console(quiet).print(f"{name} eye: {_in_words(errors[name], reference_samples)}")
    return picture


def _draw(
    scene_source: str,
    condition: Condition,
    poses: tuple[Pose | None, Pose | None],
    size_px: tuple[int, int],
    ipd_m: float,
    out: Path,
    reference_samples: int,
    advance: Advance,
) -> tuple[Path, dict[str, Any]]:
    """Draw and write everything; return the side-by-side image's path and the errors."""
    from vrcomfort.render.output import read_rgb8, write_stereo
    from vrcomfort.scene.load import load_scene

    now, before = poses
    scene = load_scene(scene_source)
    for warning in scene.warnings:
        warn(warning)
    now = now or scene.spawn @ Pose(np.array([0.0, EYE_HEIGHT_M, 0.0]))
    advance(0, "drawing")
    renderer = make_renderer(size_px)
    renderer.begin(scene, condition)
    out.mkdir(parents=True, exist_ok=True)
    pictures = _Pictures(out, advance)
    if before is not None:
        renderer.render(_frame(0, before, size_px, ipd_m), 0.0)
    rendered = renderer.render(
        _frame(1, now, size_px, ipd_m, still=before is None), PERIOD_NS / 1e9, pictures.keep
    )
    focus = [*rendered.focus_samples, *renderer.drain()][-1:]
    meta = {
        "scene": scene.name,
        "size_px": list(size_px),
        "ipd_m": ipd_m,
        "condition": condition.model_dump(mode="json"),
        "passes": list(rendered.passes),
        "head": _pose_as_data(now),
        "previous_head": _pose_as_data(before) if before else None,
        "focus": _focus_as_data(focus[0]) if focus else None,
        "triangles": rendered.triangles,
    }
    errors: dict[str, Any] = {}
    if reference_samples:
        focus_m = focus[0].focus_m if focus else condition.focus.fixed_m
        errors = meta["reference"] = _reference(
            renderer, scene, condition, pictures, focus_m, reference_samples, advance
        )
    (out / "meta.json").write_text(json.dumps(meta, indent=2) + "\n", encoding="utf-8")
    left, right = rendered.eyes
    return write_stereo(out, read_rgb8(left), read_rgb8(right))[-1], errors


def _frame(
    index: int, head: Pose, size_px: tuple[int, int], ipd_m: float, *, still: bool = False
) -> Frame:
    from vrcomfort.frame import Frame
    from vrcomfort.headset.playback import default_fovs

    half = np.array([ipd_m / 2, 0.0, 0.0])
    left, right = default_fovs(size_px)
    return Frame(
        index=index,
        predicted_display_time_ns=index * PERIOD_NS,
        period_ns=PERIOD_NS,
        head_pose=head,
        views=(View(head @ Pose(-half), left), View(head @ Pose(half), right)),
        avatar_pose=Pose(),
        discontinuity=still or index == 0,
    )


class _Pictures:
    """Keeps what is read from the GPU of each eye, and writes its numbers."""

    def __init__(self, out: Path, advance: Advance) -> None:
        self.folder = out
        self._advance = advance
        self.eyes: list[tuple[EyeImages, np.ndarray[Any, Any]]] = []

    def keep(self, index: int, images: EyeImages) -> None:
        from vrcomfort.render import output

        linear = output.read_linear(images.linear)
        arrays = {
            "linear": linear,
            "pinhole": output.read_linear(images.pinhole),
            "depth": output.read_depth(images.depth),
            "near_m": np.array(images.camera.near_m),
        }
        if images.velocity is not None:
            arrays["velocity_px"] = np.asarray(output.read_texture(images.velocity), np.float32)
        output.write_numbers(self.folder / f"{EYES[index]}.npz", **arrays)
        self.eyes.append((images, linear))
        self._advance(1)


def _reference(
    renderer: StereoRenderer,
    scene: Scene,
    condition: Condition,
    pictures: _Pictures,
    focus_m: float,
    samples: int,
    advance: Advance,
) -> dict[str, Any]:
    """Draw the ground truth of both eyes; write it and return the errors."""
    from vrcomfort.render import output
    from vrcomfort.render.image_error import accuracy, pixels_per_degree
    from vrcomfort.render.reference import Reference

    truth = Reference(renderer.ctx, scene, condition, renderer.size_px)
    errors: dict[str, Any] = {}
    for name, (images, linear) in zip(EYES, pictures.eyes, strict=True):
        camera = images.camera
        advance(0, f"brute force, {name} eye")
        drawn = truth.render(
            camera,
            PERIOD_NS / 1e9,
            images.previous,
            focus_m=focus_m,
            samples=samples,
            on_sample=lambda _: advance(1),
        )
        advance(0, f"comparing, {name} eye")
        found = accuracy(
            linear,
            _top_row_first(drawn.halves),
            pixels_per_degree=pixels_per_degree(camera.fov, renderer.size_px),
            exposure=scene.environment.exposure,
        )
        image = drawn.image[::-1].astype(np.float32)
        output.write_numbers(pictures.folder / f"{name}_reference.npz", linear=image)
        encoded = tone_mapped(image, exposure=scene.environment.exposure)
        rgb8 = np.round(encoded * 255).astype(np.uint8)
        output.write_png(pictures.folder / f"{name}_reference.png", rgb8)
        errors[name] = {**found._asdict(), "counts": found.counts and samples > 1}
        if not math.isfinite(found.psnr_db):
            errors[name]["psnr_db"] = None  # JSON has no infinity
        advance(1)
        errors["samples"], errors["note"] = drawn.samples, truth.note
    return errors


def _in_words(found: dict[str, Any], samples: int) -> str:
    """Return the error of an eye, how sure it is, and what was compared."""
    psnr = "none" if found["psnr_db"] is None else f"{found['psnr_db']:.1f} dB"
    enough = "the error counts" if found["counts"] else "more samples are needed to count"
    return (
        f"PSNR {psnr}, RMS {found['rms']:.2g}, FLIP {found['flip']:.2g} against {samples} samples "
        f"of brute force, whose own RMS is {found['reference_rms']:.2g} ({enough}); "
        f"{found['compared_px']} pixels were compared; a margin of {found['margin_px']} px and "
        f"{found['left_out_px']} pixels that are too bright or unsure were left out"
    )


def _top_row_first(halves: tuple[Any, Any]) -> tuple[Any, Any]:
    return halves[0][::-1], halves[1][::-1]


def _pose_as_data(pose: Pose) -> dict[str, list[float]]:
    return {"position_m": pose.position.tolist(), "orientation_xyzw": pose.orientation.tolist()}


def _focus_as_data(sample: Any) -> dict[str, Any]:
    return {
        "focus_m": float(sample.focus_m),
        "focus_raw_m": float(sample.focus_raw_m),
        "rays_m": [float(ray) if math.isfinite(ray) else None for ray in sample.rays_m],
        "rays_used": [bool(used) for used in sample.used],
    }
