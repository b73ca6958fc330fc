"""Stereo views of a scene as arrays, with their ground truth and error where asked for."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vrcomfort.api.outputs import Note, Progress, as_warning, no_progress
from vrcomfort.api.playback import open_trace
from vrcomfort.api.rendering import make_renderer
from vrcomfort.errors import InputError
from vrcomfort.frame import EYE_HEIGHT_M, MEAN_IPD_M
from vrcomfort.geometry import FARTHEST_M, Pose, View, yaw_pitch_roll
from vrcomfort.optics.dither import dithered
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.protocol import Condition, DepthOfField, Focus, MotionBlur

if TYPE_CHECKING:
    from vrcomfort.frame import Frame
    from vrcomfort.render.condition_passes import EyeImages
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.scene.data import Scene
    from vrcomfort.traces.trace import Trace

Rgb8 = NDArray[np.uint8]
Numbers = NDArray[np.generic]

DEFAULT_CONDITION = Condition(
    name="default",
    label="Depth of field like an eye's, and motion blur without that of turning the head",
    focus=Focus(mean="dioptres", law="linear_dioptre"),
    depth_of_field=DepthOfField(law="dioptre"),
    motion_blur=MotionBlur(),
)

PERIOD_NS = 11_111_111
"""One frame at 90 Hz between the previous pose and this one."""

EYES = ("left", "right")


@dataclass
class RenderedEye:
    """The view of one eye; all arrays have the top row first.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (height, width, 3)
        Display values (sRGB).
    arrays : dict of ndarray
        ``linear`` and ``pinhole`` (height, width, 3): linear light with and without effects;
        ``depth`` (height, width): reverse-Z; ``near_m``: its near plane; ``velocity_px``
        (height, width, 2) where the condition draws velocities.
    reference : dict of ndarray
        ``linear`` and ``rgb`` of the ground truth, where it was asked for.
    """

    rgb: Rgb8
    arrays: dict[str, Numbers]
    reference: dict[str, Numbers] = field(default_factory=dict)

    @property
    def linear(self) -> NDArray[np.float32]:
        """Return the linear light, shape (height, width, 3)."""
        return self.arrays["linear"].astype(np.float32, copy=False)

    @property
    def distance_m(self) -> NDArray[np.float32]:
        """Return the distance along the eye's axis in metres, shape (height, width); sky: inf."""
        from vrcomfort.render.output import distance_m

        depth = self.arrays["depth"].astype(np.float32, copy=False)
        return distance_m(depth, float(self.arrays["near_m"]))


@dataclass
class RenderedViews:
    """Both eyes' views of a scene; a notebook shows them side by side.

    Parameters
    ----------
    left, right : RenderedEye
        The views.
    meta : dict
        Scene, condition, passes, poses and focus, as ``meta.json`` has them; ``reference`` has the
        errors of both eyes where the ground truth was asked for.
    """

    left: RenderedEye
    right: RenderedEye
    meta: dict[str, Any]

    @property
    def side_by_side(self) -> Rgb8:
        """Return both views in one image, the left on the left, shape (height, 2 · width, 3)."""
        return np.concatenate([self.left.rgb, self.right.rgb], axis=1)

    def _repr_png_(self) -> bytes:
        from PIL import Image

        stream = io.BytesIO()
        Image.fromarray(self.side_by_side, "RGB").save(stream, "PNG")
        return stream.getvalue()

    def write(self, folder: str | Path) -> Path:
        """Write images, arrays and ``meta.json``; return the path of the side-by-side image.

        The files are ``left.png``, ``right.png``, ``side_by_side.png``, ``left.npz``,
        ``right.npz``, ``meta.json``, and of each eye ``…_velocity.png`` where the condition draws
        velocities, and a ``…_reference`` .npz and .png where there is a ground truth.
        """
        from vrcomfort.render import output

        out = Path(folder)
        out.mkdir(parents=True, exist_ok=True)
        for name, eye in zip(EYES, (self.left, self.right), strict=True):
            output.write_numbers(out / f"{name}.npz", **eye.arrays)
            if "velocity_px" in eye.arrays:
                full_px = self.meta["velocity_full_px"]
                picture = output.velocity_colours(eye.arrays["velocity_px"], full_px)
                output.write_png(out / f"{name}_velocity.png", picture)
            if eye.reference:
                linear, rgb = eye.reference["linear"], eye.reference["rgb"]
                output.write_numbers(out / f"{name}_reference.npz", linear=linear)
                output.write_png(out / f"{name}_reference.png", rgb.astype(np.uint8, copy=False))
        text = json.dumps(self.meta, indent=2) + "\n"
        (out / "meta.json").write_text(text, encoding="utf-8")
        return output.write_stereo(out, self.left.rgb, self.right.rgb)[-1]


def render_views(
    scene: str | Path,
    condition: Condition | None = None,
    *,
    pose: Pose | Sequence[float] | None = None,
    previous_pose: Pose | Sequence[float] | None = None,
    trace: Trace | str | Path | None = None,
    at_s: float | None = None,
    size_px: tuple[int, int] = (640, 800),
    ipd_m: float = MEAN_IPD_M,
    reference_samples: int = 0,
    note: Note = as_warning,
    progress: Progress = no_progress,
) -> RenderedViews:
    """Draw one stereo pair of views, which needs OpenGL but neither a window nor a GPU.

    Parameters
    ----------
    scene : str or Path
        A shipped scene (``"temple"``, ``"mountain"``) or a glTF 2.0 file.
    condition : Condition, optional
        Effects, as ``load_protocol("smoke").condition("dof")``; without it, depth of field and
        rotation-cancelled motion blur with their default settings.
    pose : Pose or sequence of 6 floats, optional
        The head in the world: x, y, z in metres; yaw, pitch, roll in degrees (left, up, roll to
        the left). Without it, a standing person at the scene's spawn point.
    previous_pose : Pose or sequence of 6 floats, optional
        The head one frame (1/90 s) earlier; without it, at rest.
    trace : Trace, str or Path, optional
        A head trace in place of the poses: head, hands and locomotion of the sample at `at_s`, and
        of the one before.
    at_s : float, optional
        Seconds from the first sample of the trace, and the time of the scene's animations, which
        have moved since the frame before. Without it, nothing moves but the head.
    size_px : tuple of int
        (width, height) of one eye's image.
    ipd_m : float
        Distance between the pupils in metres.
    reference_samples : int
        Lens and shutter samples of the ground truth; 0 draws none.
    note, progress : callable
        Take notes on the scene, and finished steps.

    Returns
    -------
    RenderedViews
        Arrays of both eyes; a notebook shows them.

    Raises
    ------
    InputError
        If the scene, a pose or a trace cannot be used, there is no OpenGL 4.5, or no FLIP for a
        reference.

    Examples
    --------
    >>> import vrcomfort
    >>> views = vrcomfort.render_views("temple", size_px=(320, 400))  # doctest: +SKIP
    >>> views.left.linear.shape  # doctest: +SKIP
    (400, 320, 3)
    """
    from vrcomfort.tradeoff.image_error import margin_px, require_flip

    view = _Moment(as_pose(pose), as_pose(previous_pose), _trace(trace, note), at_s)
    view.check()
    if reference_samples:  # before anything is drawn
        margin_px(size_px)  # refuses an image that is all margin
        require_flip()
    steps = 2 * (1 + reference_samples + bool(reference_samples))
    with progress("loading", steps, unit="steps") as advance:
        return _draw(
            str(scene), condition or DEFAULT_CONDITION, view, size_px, ipd_m,
            reference_samples, note, advance,
        )  # fmt: skip


def _trace(trace: Trace | str | Path | None, note: Note) -> Trace | None:
    return open_trace(Path(trace), note=note) if isinstance(trace, str | Path) else trace


@dataclass(frozen=True)
class _Moment:
    """The head poses of a view, or a moment of a trace; and the time of animations."""

    pose: Pose | None
    previous_pose: Pose | None
    trace: Trace | None
    at_s: float | None

    @property
    def time_s(self) -> float:
        """Return the time of the scene's animations."""
        return PERIOD_NS / 1e9 if self.at_s is None else self.at_s

    def check(self) -> None:
        """Refuse poses beside a trace, and times that are none of it."""
        if self.at_s is not None and not (math.isfinite(self.at_s) and self.at_s >= 0):
            raise InputError(f"{self.at_s} s is no time; give seconds from 0 on")
        if self.trace is None:
            return
        if self.pose is not None or self.previous_pose is not None:
            raise InputError("a pose and a trace were given; leave one out")
        length_s = (self.trace.time_ns[-1] - self.trace.time_ns[0]) / 1e9
        if self.time_s > length_s:
            message = f"the trace has nothing at {self.time_s:g} s: it is {length_s:.1f} s long"
            raise InputError(f"{message}; choose a time within it")

    def frames(
        self, scene: Scene, size_px: tuple[int, int], ipd_m: float
    ) -> tuple[Frame | None, Frame]:
        """Return the frame before, if it counts, and the frame."""
        if self.trace is not None:
            return self._of_trace(self.trace, scene, size_px, ipd_m)
        now = self.pose or scene.spawn @ Pose(np.array([0.0, EYE_HEIGHT_M, 0.0]))
        moves = self.previous_pose is not None or self.at_s is not None
        before = _frame(0, self.previous_pose or now, size_px, ipd_m) if moves else None
        return before, _frame(1, now, size_px, ipd_m, still=not moves)

    def _of_trace(
        self, trace: Trace, scene: Scene, size_px: tuple[int, int], ipd_m: float
    ) -> tuple[Frame | None, Frame]:
        from vrcomfort.headset.playback import PlaybackHeadset

        at_ns = int(trace.time_ns[0]) + round(self.time_s * 1e9)
        row = max(int(trace.time_ns.searchsorted(at_ns, side="right")) - 1, 0)
        headset = PlaybackHeadset(trace, image_size_px=size_px, ipd_m=ipd_m, spawn=scene.spawn)
        *before, now = islice(headset.frames(), max(row - 1, 0), row + 1)
        return (before[0] if before else None), now


def as_pose(pose: Pose | Sequence[float] | None, given: str = "") -> Pose | None:
    """Return world-from-head of six numbers: metres, and degrees of yaw, pitch and roll.

    Parameters
    ----------
    given
        The pose as it was typed, for messages.

    Raises
    ------
    InputError
        If they are not six finite numbers, or too far from the scene's origin.
    """
    if pose is None or isinstance(pose, Pose):
        return pose
    numbers = [float(number) for number in pose]
    given = given or str(tuple(pose))
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        raise InputError(
            f"{given} is not a pose; write X,Y,Z,YAW,PITCH,ROLL "
            "in metres and degrees, for example 0,1.6,0,30,-5,0"
        )
    if max(map(abs, numbers[:3])) > FARTHEST_M:
        raise InputError(
            f"{given} is more than {FARTHEST_M / 1e3:.0f} km from the "
            "scene's origin; positions are metres"
        )
    return Pose(np.array(numbers[:3]), yaw_pitch_roll(*np.radians(numbers[3:])))


def _draw(
    scene_source: str,
    condition: Condition,
    moment: _Moment,
    size_px: tuple[int, int],
    ipd_m: float,
    reference_samples: int,
    note: Note,
    advance: Callable[..., None],
) -> RenderedViews:
    from vrcomfort.render.output import read_rgb8
    from vrcomfort.scene.load import load_scene

    scene = load_scene(scene_source)
    for warning in scene.warnings:
        note(warning)
    before, now = moment.frames(scene, size_px, ipd_m)
    if reference_samples and scene.has_hands and any(now.hands):
        raise InputError("the ground truth draws nothing in hands; leave --reference out")
    advance(0, "drawing")
    renderer = make_renderer(size_px)
    renderer.begin(scene, condition)
    drawn: list[tuple[EyeImages, dict[str, Numbers]]] = []

    def keep(index: int, images: EyeImages) -> None:
        del index  # left, then right
        drawn.append((images, _arrays(images)))
        advance(1)

    if before is not None:
        passed_ns = now.predicted_display_time_ns - before.predicted_display_time_ns
        renderer.render(before, moment.time_s - passed_ns / 1e9)
    rendered = renderer.render(now, moment.time_s, keep)
    focus = [*rendered.focus_samples, *renderer.drain()][-1:]
    meta = {
        "scene": scene.name,
        "size_px": list(size_px),
        "ipd_m": ipd_m,
        "condition": condition.model_dump(mode="json"),
        "passes": list(rendered.passes),
        "time_s": moment.time_s,
        "head": _head_as_data(now),
        "previous_head": _head_as_data(before) if before else None,
        "focus": _focus_as_data(focus[0]) if focus else None,
        "triangles": rendered.triangles,
    }
    if "velocity_px" in drawn[0][1]:
        meta["velocity_full_px"] = _full_px([arrays["velocity_px"] for _, arrays in drawn])
    left, right = (
        RenderedEye(read_rgb8(texture), arrays)
        for texture, (_, arrays) in zip(rendered.eyes, drawn, strict=True)
    )
    if reference_samples:
        focus_m = focus[0].focus_m if focus else condition.focus.fixed_m
        images = [each for each, _ in drawn]
        meta["reference"] = _reference(
            renderer, scene, condition, images, (left, right), focus_m, moment.time_s,
            reference_samples, advance,
        )  # fmt: skip
    renderer.release()  # a notebook draws many views in one process
    return RenderedViews(left, right, meta)


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


def _arrays(images: EyeImages) -> dict[str, Numbers]:
    from vrcomfort.render import output

    arrays: dict[str, Numbers] = {
        "linear": output.read_linear(images.linear),
        "pinhole": output.read_linear(images.pinhole),
        "depth": output.read_depth(images.depth),
        "near_m": np.array(images.camera.near_m),
    }
    if images.velocity is not None:
        arrays["velocity_px"] = np.asarray(output.read_texture(images.velocity), np.float32)
    return arrays


def _reference(
    renderer: StereoRenderer,
    scene: Scene,
    condition: Condition,
    drawn: list[EyeImages],
    eyes: tuple[RenderedEye, RenderedEye],
    focus_m: float,
    time_s: float,
    samples: int,
    advance: Callable[..., None],
) -> dict[str, Any]:
    """Draw the ground truth of both eyes into their `reference`, and return the errors."""
    from vrcomfort.tradeoff.brute_force import Reference
    from vrcomfort.tradeoff.image_error import accuracy, pixels_per_degree

    truth = Reference(renderer.ctx, scene, condition, renderer.size_px)
    errors: dict[str, Any] = {}
    for name, images, eye in zip(EYES, drawn, eyes, strict=True):
        camera = images.camera
        advance(0, f"brute force, {name} eye")
        rendered = truth.render(
            camera,
            time_s,
            images.previous,
            focus_m=focus_m,
            samples=samples,
            on_sample=lambda _: advance(1),
        )
        advance(0, f"comparing, {name} eye")
        found = accuracy(
            eye.linear,
            (rendered.halves[0][::-1], rendered.halves[1][::-1]),  # top row first
            pixels_per_degree=pixels_per_degree(camera.fov, renderer.size_px),
            exposure=scene.environment.exposure,
        )
        image = rendered.image[::-1].astype(np.float32)
        encoded = tone_mapped(image, exposure=scene.environment.exposure)
        eye.reference["linear"] = image
        eye.reference["rgb"] = dithered(encoded)
        errors[name] = {**found._asdict(), "counts": found.counts and samples > 1}
        if not math.isfinite(found.psnr_db):
            errors[name]["psnr_db"] = None  # JSON has no infinity
        advance(1)
        errors["samples"], errors["note"] = rendered.samples, truth.note
    return errors


LONGEST_SHARE = 0.99
"""Share of the pixels whose velocities have a colour of their own in a picture of them."""


def _full_px(velocities: list[Numbers]) -> float:
    """Return the velocity of the fullest colour, in pixels per frame; at least one pixel."""
    lengths = np.hypot(*np.moveaxis(np.stack(velocities).astype(np.float64), -1, 0)[:2])
    return max(round(float(np.quantile(lengths, LONGEST_SHARE)), 2), 1.0)


def _head_as_data(frame: Frame) -> dict[str, list[float]]:
    return _pose_as_data(frame.avatar_pose @ frame.head_pose)


def _pose_as_data(pose: Pose) -> dict[str, list[float]]:
    return {"position_m": pose.position.tolist(), "orientation_xyzw": pose.orientation.tolist()}


def _focus_as_data(sample: Any) -> dict[str, Any]:
    return {
        "focus_m": float(sample.focus_m),
        "focus_raw_m": float(sample.focus_raw_m),
        "rays_m": [float(ray) if math.isfinite(ray) else None for ray in sample.rays_m],
        "rays_used": [bool(used) for used in sample.used],
    }
