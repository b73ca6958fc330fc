"""From a frame's poses to two images: wires the passes that a condition needs in a scene.

::

    focus (head centre, once)
      |    per eye:         both eyes at once:
      +--> scene ---------> effects, in the condition's order ----> tone map --> eyes
           colour           (depth of field, motion blur, …)
           depth, velocity
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import moderngl
import numpy as np

from vrcomfort.frame import FocusSample, Frame, GazeHit, GpuTime, ImageHash, PartTime
from vrcomfort.geometry import Fov, Gaze, HiddenAreas, Pose, View, yaw_pitch_roll
from vrcomfort.gpu import gl
from vrcomfort.gpu import memory as gpu_memory
from vrcomfort.gpu.passes import PassOrder, part, watched
from vrcomfort.gpu.timer import GpuTimer, PartTimer, make_gpu_timer
from vrcomfort.gpu.visible_area import VisibleArea
from vrcomfort.optics.focus import Centre
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.viewing import DepthMode, Photodiode
from vrcomfort.render.camera import (
    NEAR_M,
    EyeCamera,
    HeadStep,
    PreviousCamera,
    hand_poses,
    previous_eye_pose,
    turned_like,
)
from vrcomfort.render.condition_passes import ConditionPasses, EyeImages
from vrcomfort.render.display import ImageHasher, PatchPainter
from vrcomfort.render.effects.effect import EyeFrame
from vrcomfort.render.focus.search import FocusPass
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Scene


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """Two images, and the measurements taken with them.

    Parameters
    ----------
    eyes
        Left and right, RGBA8, sRGB-encoded, rows from the bottom; valid until the next frame.
    focus_samples
        Those that arrived during this frame; each carries its own frame index.
    max_blur_px
        Largest radius (or half streak) that the condition allows at this image size; None where
        views through the lens have no limit.
    draws, triangles
        Draw calls for geometry, and triangles sent, of all views including shadow and focus.
    passes
        Names of the passes that ran.
    cpu_ms
        Wall time of this call, without that of `on_eye`.
    gpu_times
        Those of earlier frames that have arrived; None where the GPU is not timed.
    times_parts
        Whether its parts are being timed.
    part_times
        Those of parts of earlier frames that have arrived, where parts are timed.
    hashed
        Whether its images are being hashed.
    image_hashes
        Those of earlier frames that have arrived, where images are hashed.
    seeks_gaze
        Whether the gaze hit of this frame is being sought.
    gaze_hits
        Those of earlier frames that have arrived.
    effect_centre
        Centre of gaze-contingent effects: ``gaze``, ``held`` or ``head``;
        None where the condition has none.
    """

    eyes: tuple[moderngl.Texture, moderngl.Texture]
    focus_samples: tuple[FocusSample, ...]
    max_blur_px: float | None
    draws: int
    triangles: int
    passes: tuple[str, ...]
    cpu_ms: float
    gpu_times: tuple[GpuTime, ...] | None = None
    times_parts: bool = False
    part_times: tuple[PartTime, ...] = ()
    hashed: bool = False
    image_hashes: tuple[ImageHash, ...] = ()
    seeks_gaze: bool = False
    gaze_hits: tuple[GazeHit, ...] = ()
    effect_centre: str | None = None


class _Before(NamedTuple):
    """Poses and times of a frame, kept for the next."""

    head_pose: Pose
    avatar_pose: Pose
    scene_time_s: float
    display_time_ns: int
    hands: tuple[Pose | None, Pose | None]


class StereoRenderer:
    """Renders stereo frames: `begin` a condition in a scene, then `render` its frames.

    Parameters
    ----------
    size_px
        (width, height) of one eye's image.
    samples
        Multisampling.
    near_m
        Distance of the near plane.
    eyes
        1 draws the left eye alone, and gives its image for both.
    on_eye
        Called with each eye (0 left, 1 right) of each frame and its textures, where `render` is not
        told otherwise.
    hash_every
        Frames from one hash of the images to the next, the first of each `begin` among them; 0: no
        hashes.
    time_parts_every
        Drawn frames from one whose parts are timed to the next; 0: none.
    headset_depth
        Which depth `on_eye` gets as `EyeImages.headset_depth`.
    photodiode
        The patch that frames with a `Frame.patch` have.
    finds_hits
        Find the hit of each frame's gaze, where it has one.
    hidden
        What the lens of each eye never shows: it is not drawn, and stays black.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        size_px: tuple[int, int],
        *,
        samples: int = 4,
        near_m: float = NEAR_M,
        eyes: Literal[1, 2] = 2,
        on_eye: Callable[[int, EyeImages], None] | None = None,
        hash_every: int = 0,
        time_parts_every: int = 0,
        headset_depth: DepthMode = "scene",
        photodiode: Photodiode | None = None,
        finds_hits: bool = False,
        hidden: HiddenAreas = (None, None),
    ) -> None:
        self.size_px = size_px
        self._hash_every, self._time_parts_every = hash_every, time_parts_every
        self._hasher: ImageHasher | None = None
        self._drawn = 0
        self._headset_depth: DepthMode = headset_depth
        self._finds_hits, self._has_tracker = finds_hits, False
        self._photodiode, self._hidden = photodiode, hidden
        self._patch: PatchPainter | None = None
        self._eyes = eyes
        self.ctx = ctx
        self._samples = samples
        self._near_m = near_m
        self._on_eye = on_eye
        self._passes: ConditionPasses | None = None
        self._before: _Before | None = None
        self._timer: GpuTimer | None = None
        self._part_timer: PartTimer | None = None

    def begin(self, scene: Scene, condition: Condition) -> None:
        """Build the passes that `condition` needs in `scene`; those of before are released.

        Drivers compile at the first draw, so two frames are drawn that are never shown.

        Raises
        ------
        ValueError
            If passes stand in a cycle or in the wrong order, with their names.
        """
        self.build(scene, condition)
        passes = self._built()
        order = PassOrder()
        with watched(order):
            for frame in looks_around(scene.spawn):
                self._draw(frame, 0.0, None)
        order.check()
        passes.warm_up()
        # Warm-up frames must leave nothing behind: no samples, no maxima, no frame before.
        self.drain()
        self.drain_gaze_hits()
        passes.reset()
        self._before = None
        self._drawn = 0
        self.ctx.finish()
        self._timer = make_gpu_timer(self.ctx)
        self._part_timer = PartTimer(self.ctx) if self._time_parts_every else None

    def adjust(self, condition: Condition) -> None:
        """Change settings of the present condition between two frames; nothing is built anew.

        Parameters
        ----------
        condition
            Differs from that of `begin` only in settings that are `ADJUSTABLE`.
        """
        self._condition = condition
        self._built().adjust(condition)

    def build(self, scene: Scene, condition: Condition) -> None:
        """Build the passes as `begin` does, and draw nothing yet."""
        self.release()
        self._scene = scene
        self._has_hands = scene.has_hands
        self._condition = condition
        account = gpu_memory.account(self.ctx)
        first = account.mark()
        self._passes = ConditionPasses(
            self.ctx, scene, condition, self.size_px, samples=self._samples, near_m=self._near_m,
            eyes=self._eyes, headset_depth=self._headset_depth, hidden=self._hidden,
        )  # fmt: skip
        if self._photodiode is not None:
            self._patch = PatchPainter(self.ctx, self._photodiode, self._passes.encoded)
        self._allocated = first, account.mark()

    def memory(self) -> tuple[gpu_memory.GpuAllocation, ...]:
        """Return the textures and buffers of the present condition and scene."""
        self._built()
        return gpu_memory.account(self.ctx).between(*self._allocated)

    def plan(self) -> list[PlannedPass]:
        """Return the passes of the present condition and scene, with reasons."""
        return plan_passes(self._scene, self._condition)

    @property
    def area(self) -> VisibleArea | None:
        """Return the tiles that are drawn; None where no lens hides anything."""
        return self._built().area

    @property
    def scene_pass(self) -> ScenePass:
        """Return the scene pass of the present condition."""
        return self._built().scene

    @property
    def focus(self) -> FocusPass | None:
        """Return the search for the focus of the present condition, where there is one."""
        return self._built().focus

    def leave_out_records(self) -> None:
        """Draw nothing from now on that serves only the record of limits: for measurements."""
        self._built().leave_out_records()

    def render(
        self,
        frame: Frame,
        scene_time_s: float,
        on_eye: Callable[[int, EyeImages], None] | None = None,
    ) -> RenderedFrame:
        """Render both eyes of a frame.

        Parameters
        ----------
        scene_time_s
            Time of the scene's animations.
        on_eye
            Called with each eye (0 left, 1 right) and its textures, for files and measurements.
        """
        on_eye = on_eye or self._on_eye
        timer, parts = self._timer, self._part_timer
        times_parts = parts is not None and self._drawn % self._time_parts_every == 0
        with (
            nullcontext() if timer is None else timer.frame(frame.index),
            parts.frame(frame.index) if parts is not None and times_parts else nullcontext(),
        ):
            rendered = self._draw(frame, scene_time_s, on_eye)
        if timer is not None:
            rendered = replace(rendered, gpu_times=timer.arrived())
        if parts is not None:
            rendered = replace(rendered, times_parts=times_parts, part_times=parts.arrived())
        rendered = self._hashed(frame, rendered)
        self._drawn += 1
        return rendered

    def _look_along(self, frame: Frame, world_from_head: Pose) -> tuple[bool, tuple[GazeHit, ...]]:
        """Seek the gaze hit; return whether it is sought, and the hits that have arrived.

        Warm-up frames seek it as well once an eye tracker has been seen: without one, no program or
        buffer is made for it.
        """
        if not self._finds_hits or frame.gaze is None:
            return False, ()
        self._has_tracker |= frame.index >= 0
        if not self._has_tracker:
            return False, ()
        with part("gaze_hit"):
            return self._built().look_along(frame, world_from_head)

    def _hashed(self, frame: Frame, rendered: RenderedFrame) -> RenderedFrame:
        """Begin to hash a frame's images if it is its turn; add the hashes that have arrived."""
        if not self._hash_every:
            return rendered
        hasher = self._get_hasher()
        hashed = self._drawn % self._hash_every == 0
        if hashed:
            hasher.take(frame.index, rendered.eyes)
        return replace(rendered, hashed=hashed, image_hashes=hasher.arrived())

    def _get_hasher(self) -> ImageHasher:
        self._hasher = self._hasher or ImageHasher(self.ctx)
        return self._hasher

    def _draw(
        self,
        frame: Frame,
        scene_time_s: float,
        on_eye: Callable[[int, EyeImages], None] | None,
    ) -> RenderedFrame:
        start_s, elsewhere_s = time.perf_counter(), 0.0
        gl.collect(self.ctx)  # objects of the condition before are released here, not in mid-frame
        passes = self._built()
        gpu = passes.scene.gpu
        gpu.draws = gpu.triangles = 0
        if passes.area is not None:  # frames that warm up are seen by nobody: they are drawn whole
            seen = frame.views[: self._eyes] if frame.index >= 0 else ()
            passes.area.look([view.fov for view in seen])
        before = None if frame.discontinuity else self._before
        if before is not None and frame.snap_turn:
            before = _without_turn(before, frame)
        world_from_head = frame.avatar_pose @ frame.head_pose
        if self._has_hands:
            self._place_hands(frame, before)
        centre = passes.centre(frame)
        # Both eyes are known before anything is drawn: they are culled together. Then the focus,
        # which resolves, lenses and depth of field of both eyes read on the GPU.
        step, head_from_stage = before and _step(before, frame), frame.head_pose.inverse()
        eyes = [
            self._eye(
                index, frame, scene_time_s, head_from_stage, world_from_head, before, step, centre
            )
            for index in range(self._eyes)
        ]
        passes.place(eyes, scene_time_s)
        samples = passes.find_focus(frame, world_from_head, scene_time_s, centre)
        seeks_gaze, hits = self._look_along(frame, world_from_head)
        # A headset takes depth alone.
        keep_pinhole = on_eye is not None and on_eye is not self._on_eye

        def hand_on(index: int, images: EyeImages) -> None:
            nonlocal elsewhere_s
            if on_eye is not None:
                elsewhere_s += self._hand_on(on_eye, index, images)

        take = None if on_eye is None else hand_on
        passes.render(eyes, scene_time_s, take, keep_pinhole=keep_pinhole)
        if self._patch is not None and frame.patch is not None:
            self._patch.paint(tuple(view.fov for view in frame.views), white=frame.patch)
        self._before = _Before(
            frame.head_pose,
            frame.avatar_pose,
            scene_time_s,
            frame.predicted_display_time_ns,
            frame.hands,
        )
        return RenderedFrame(
            # With one eye, its image stands for both.
            eyes=(passes.encoded[0], passes.encoded[-1]),
            focus_samples=samples,
            max_blur_px=passes.max_blur_px,
            draws=gpu.draws,
            triangles=gpu.triangles,
            passes=passes.names,
            seeks_gaze=seeks_gaze,
            gaze_hits=hits,
            effect_centre=None if centre is None else centre.source,
            cpu_ms=(time.perf_counter() - start_s - elsewhere_s) * 1e3,
        )

    def _hand_on(
        self, on_eye: Callable[[int, EyeImages], None], index: int, images: EyeImages
    ) -> float:
        """Give an eye's textures away; return the seconds that it took, which nothing else has."""
        start_s = time.perf_counter()
        with self._timer.paused() if self._timer is not None else nullcontext():
            on_eye(index, images)
        return time.perf_counter() - start_s

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the focus samples that are still on their way (this waits for the GPU)."""
        focus = None if self._passes is None else self._passes.focus
        return () if focus is None else focus.drain()

    def clamps(self) -> tuple[str, ...]:
        """Return which limits have shortened a blur since `begin`, in words; waits for the GPU."""
        return self._built().clamps()

    def drain_gaze_hits(self) -> tuple[GazeHit, ...]:
        """Return all gaze hits that are still on their way; waits for the GPU."""
        hits = None if self._passes is None else self._passes.gaze_hits
        return () if hits is None else hits.drain()

    def drain_times(self) -> tuple[GpuTime, ...]:
        """Return the GPU times that are still on their way (this waits for the GPU)."""
        return () if self._timer is None else self._timer.drain()

    def drain_part_times(self) -> tuple[PartTime, ...]:
        """Return the times of parts that are still on their way (this waits for the GPU)."""
        return () if self._part_timer is None else self._part_timer.drain()

    def hash_now(self, frame_index: int) -> ImageHash:
        """Return the hashes of the images that were drawn last (this waits for the GPU)."""
        encoded = self._built().encoded
        hasher = self._get_hasher()
        hasher.take(frame_index, (encoded[0], encoded[-1]))
        return hasher.drain()[-1]

    def drain_hashes(self) -> tuple[ImageHash, ...]:
        """Return the hashes of images that are still on their way (this waits for the GPU)."""
        return () if self._hasher is None else self._hasher.drain()

    def release(self) -> None:
        """Let go of everything on the GPU; `begin` may follow."""
        self._passes = None
        self._patch = None
        self._before = None
        self._timer = self._part_timer = None
        gl.collect(self.ctx)

    def _built(self) -> ConditionPasses:
        if self._passes is None:
            raise RuntimeError("StereoRenderer.begin was not called")
        return self._passes

    def _place_hands(self, frame: Frame, before: _Before | None) -> None:
        """Move the nodes bound to the hands; after a cut they have not moved."""
        blur = self._condition.motion_blur
        carried = "with_head" if blur is None else blur.hands
        hands, counted = hand_poses(
            carried,
            world_from_stage=frame.avatar_pose,
            stage_from_head=frame.head_pose,
            stage_from_hands=frame.hands,
            previous_world_from_stage=before.avatar_pose if before else frame.avatar_pose,
            previous_stage_from_head=before.head_pose if before else frame.head_pose,
            previous_stage_from_hands=before.hands if before else (None, None),
        )
        gpu = self._built().scene.gpu
        gpu.place_hands(hands, counted, with_head=carried == "with_head")

    def _eye(
        self,
        index: int,
        frame: Frame,
        scene_time_s: float,
        head_from_stage: Pose,
        world_from_head: Pose,
        before: _Before | None,
        step: HeadStep | None,
        centre: Centre | None,
    ) -> EyeFrame:
        view, time_ns = frame.views[index], frame.predicted_display_time_ns
        head_from_eye = head_from_stage @ view.pose
        # Composed as `previous_eye_pose` does, so that a head that rests gives equal bits.
        world_from_eye = world_from_head @ head_from_eye
        passes = self._built()
        camera = EyeCamera(
            world_from_eye,
            view.fov,
            self._near_m,
            world_from_head,
            head_from_eye,
            peripheral_axis=passes.axis("peripheral", centre),
            vignette_axis=passes.axis("vignette", centre),
        )
        blur, previous = self._condition.motion_blur, PreviousCamera(world_from_eye, scene_time_s)
        if before is None or blur is None:
            return EyeFrame(index, time_ns, head_from_eye, camera, previous, step)
        pose = previous_eye_pose(
            blur.mode,
            world_from_stage=frame.avatar_pose,
            stage_from_head=frame.head_pose,
            head_from_eye=head_from_eye,
            previous_world_from_stage=before.avatar_pose,
            previous_stage_from_head=before.head_pose,
            virtual_turning=blur.virtual_turning,
            neck=blur.neck,
        )
        previous = PreviousCamera(pose, before.scene_time_s)
        return EyeFrame(index, time_ns, head_from_eye, camera, previous, step)


def _without_turn(before: _Before, frame: Frame) -> _Before:
    """Return the frame before as if the avatar had been turned already."""
    avatar = turned_like(before.avatar_pose, frame.avatar_pose, frame.head_pose)
    return before._replace(avatar_pose=avatar)


def _step(before: _Before, frame: Frame) -> HeadStep:
    elapsed_ns = frame.predicted_display_time_ns - before.display_time_ns
    return HeadStep(
        before.head_pose,
        frame.head_pose,
        before.avatar_pose,
        frame.avatar_pose,
        seconds=elapsed_ns / 1e9,
        # A runtime's predictions waver about whole periods.
        periods=max(round(elapsed_ns / frame.period_ns), 1),
        snap_turn=frame.snap_turn,
    )


EYES_M = (0.0, 1.6, 0.0)
WIDE = Fov(-1.2, 1.2, 1.2, -1.2)
"""Radians: two frames back to back see nearly everything around."""

LATEST_NS = 2**63 - 1
"""After it every frame goes back in time, which resets all state from earlier frames."""


def looks_around(spawn: Pose) -> tuple[Frame, ...]:
    """Return a look ahead and one back, from eye height above the point where a scene begins.

    Both eyes and hands are at the same place. The gaze is straight ahead: whether there is an eye
    tracker matters later.
    """
    heads = (Pose(np.array(EYES_M), yaw_pitch_roll(yaw_rad, 0.0, 0.0)) for yaw_rad in (0.0, np.pi))
    return tuple(
        Frame(
            index=-1,
            predicted_display_time_ns=LATEST_NS,
            period_ns=1,
            head_pose=head,
            views=(View(head, WIDE), View(head, WIDE)),
            avatar_pose=spawn,
            discontinuity=True,
            gaze=Gaze(head),
            hands=(head, head),
        )
        for head in heads
    )
