"""The passes of one condition in one scene, wired by their textures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import moderngl

from vrcomfort.frame import FocusSample, Frame
from vrcomfort.geometry import Pose
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render import plan
from vrcomfort.render.camera import EyeCamera, Lens, PreviousCamera
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.depth_of_field.lens_views import LensViews, blur_of_one_view
from vrcomfort.render.effects.motion_blur.effect import MotionBlurPass
from vrcomfort.render.effects.speed_blur import SpeedBlurPass
from vrcomfort.render.focus.passes import FixedFocus, FocusPass, make_focus_pass
from vrcomfort.render.focus.rays import screen_tangents
from vrcomfort.render.frames import EyeImages, head_from_gaze
from vrcomfort.render.head_step import HeadStep
from vrcomfort.render.plan import plan_passes
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.render.tone_map import ToneMapPass
from vrcomfort.scene.data import Scene


class PlacedEye(NamedTuple):
    """An eye of this frame, and what motion blur counts as the eye of the frame before."""

    head_from_eye: Pose
    camera: EyeCamera
    previous: PreviousCamera | None
    step: HeadStep | None = None
    """How the head got here; None where the frame before has nothing to do with this one."""


class ConditionPasses:
    """The passes of one condition in one scene, wired by their textures.

    With several views through the lens, motion blur that comes first blurs each view along its own
    velocities; motion blur that comes after depth of field blurs the mean of the views along those
    of the centre view, which is drawn last: its colour, depth and velocity are the eye's.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        condition: Condition,
        size_px: tuple[int, int],
        *,
        samples: int,
        near_m: float,
        eyes: int = 2,
    ) -> None:
        self._ctx = ctx
        self._size_px = size_px
        self._near_m = near_m
        self.names = tuple(item.name for item in plan_passes(scene, condition) if item.needed)
        velocity = plan.velocity(scene, condition).needed
        self._lens_views: LensViews | None = None
        blur = condition.depth_of_field if plan.depth_of_field(condition).needed else None
        self.scene = ScenePass(
            ctx,
            scene,
            size_px,
            velocity=velocity,
            samples=samples,
            lens_law="dioptre" if blur is not None and blur.views > 1 else None,
        )
        self.focus: FocusPass | FixedFocus | None = None
        self._depth_of_field: DepthOfFieldPass | None = None
        self._motion_blur: MotionBlurPass | None = None
        self._speed_blur: SpeedBlurPass | None = None
        self.triangles = 0
        """Of the eye that was drawn last, in all its views."""
        self.colour = self.scene.colour
        effects = [self._add_depth_of_field, self._add_motion_blur]
        if condition.effect_order == "motion_blur_first":
            effects.reverse()
        for add in effects:
            add(condition)
        self._add_speed_blur(condition)
        self._blur_first = condition.effect_order == "motion_blur_first"
        exposure = scene.environment.exposure
        self.tone_maps = tuple(
            ToneMapPass(ctx, radiance=self.colour, size_px=size_px, exposure=exposure)
            for _ in range(eyes)
        )

    def _add_depth_of_field(self, condition: Condition) -> None:
        settings = condition.depth_of_field
        if settings is None or not plan.depth_of_field(condition).needed:
            return
        focus, near_m = condition.focus, self._near_m
        self.focus = make_focus_pass(self._ctx, self.scene.gpu, focus, near_m=near_m)
        of_one_view = blur_of_one_view(settings, self._size_px)
        if of_one_view is not None:
            self._depth_of_field = DepthOfFieldPass(
                self._ctx,
                colour=self.colour,
                depth=self.scene.depth,
                focus=self.focus.texture,
                settings=of_one_view,
                size_px=self._size_px,
                infinity_m=focus.infinity_m,
            )
            self.colour = self._depth_of_field.target
        if settings.views > 1:
            self.scene.lens_focus = self.focus.texture
            self._lens_views = LensViews(self._ctx, self.colour, settings, focus.infinity_m)
            self.colour = self._lens_views.target

    def _add_motion_blur(self, condition: Condition) -> None:
        settings = condition.motion_blur
        velocity = self.scene.velocity
        if settings is None or velocity is None:
            return
        self._motion_blur = MotionBlurPass(
            self._ctx,
            colour=self.colour,
            depth=self.scene.depth,
            velocity=velocity,
            settings=settings,
            size_px=self._size_px,
        )
        self.colour = self._motion_blur.target

    def _add_speed_blur(self, condition: Condition) -> None:
        settings = condition.speed_blur
        if settings is None or not plan.speed_blur(condition).needed:
            return
        self._speed_blur = SpeedBlurPass(
            self._ctx, colour=self.colour, settings=settings, size_px=self._size_px
        )
        self.colour = self._speed_blur.target

    def warm_up(self) -> None:
        """Draw once what frames in which nothing moves leave out, so that it is compiled."""
        for effect in (self._motion_blur, self._speed_blur):
            if effect is not None:
                effect.warm_up()

    @property
    def max_blur_px(self) -> float | None:
        """Return the largest radius or half streak there can be; None: views have no limit."""
        if self._lens_views is not None:
            return None
        effects = self._depth_of_field, self._motion_blur
        return max((effect.limit_px for effect in effects if effect is not None), default=0.0)

    def clamps(self) -> tuple[str, ...]:
        """Return which limits have shortened a blur so far, in words; waits for the GPU."""
        lens = self._depth_of_field.clamps() if self._depth_of_field else ()
        if self._lens_views is not None:
            views = f"in each of {self._lens_views.views} views through the lens"
            lens = tuple(f"{clamp} {views}; their mean has no limit" for clamp in lens)
        return lens + (self._motion_blur.clamps() if self._motion_blur else ())

    def forget(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        if self._depth_of_field is not None:
            self._depth_of_field.forget()

    def find_focus(self, frame: Frame, world_from_head: Pose) -> tuple[FocusSample, ...]:
        """Decide the focus of both eyes, and return the samples that have arrived."""
        if self.focus is None:
            return ()
        return self.focus.render(
            frame_index=frame.index,
            display_time_ns=frame.predicted_display_time_ns,
            world_from_head=world_from_head,
            discontinuity=frame.discontinuity,
            screen_tangents=screen_tangents(frame.views),
            gaze=head_from_gaze(frame),
        )

    def render_eye(
        self, index: int, eye: PlacedEye, scene_time_s: float, before_s: float
    ) -> EyeImages:
        """Draw one eye (0 left, 1 right) and its effects."""
        camera = eye.camera
        previous = eye.previous or PreviousCamera(camera.world_from_eye, before_s)
        self.triangles = 0

        def draw(lens: Lens | None = None) -> None:
            self.scene.render(replace(camera, lens=lens), scene_time_s, previous)
            self.triangles += self.scene.triangles

        if self._lens_views is None:
            self._render_once(eye, draw)
        else:
            self._render_views(eye, draw, self._lens_views)
        if self._speed_blur is not None:
            self._speed_blur.render(fov=camera.fov, step=eye.step)
        self.tone_maps[index].render()
        return EyeImages(
            camera,
            eye.previous,
            self.scene.colour,
            self.colour,
            self.scene.depth,
            self.scene.velocity,
            self.tone_maps[index].target,
        )

    def _render_once(self, eye: PlacedEye, draw: Callable[[], None]) -> None:
        steps = [self._blur_defocus, self._blur_motion]
        draw()
        for step in reversed(steps) if self._blur_first else steps:
            step(eye)

    def _render_views(
        self, eye: PlacedEye, draw: Callable[[Lens | None], None], views: LensViews
    ) -> None:
        def draw_and_blur(lens: Lens) -> None:
            draw(lens)
            if self._blur_first:
                self._blur_motion(eye)
            self._blur_defocus(eye)

        views.render(eye.camera.fov, draw_and_blur)
        draw(None)
        if not self._blur_first:
            self._blur_motion(eye)

    def _blur_defocus(self, eye: PlacedEye) -> None:
        if self._depth_of_field is not None:
            self._depth_of_field.render(
                fov=eye.camera.fov, near_m=eye.camera.near_m, head_from_eye=eye.head_from_eye
            )

    def _blur_motion(self, eye: PlacedEye) -> None:
        if self._motion_blur is not None:
            self._motion_blur.render(still=self.scene.still, step=eye.step)
