"""The passes of one condition in one scene, wired by their textures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import moderngl

from vrcomfort.errors import InputError
from vrcomfort.frame import FocusSample, Frame, GazeHit
from vrcomfort.geometry import Array, Gaze, HiddenAreas, Pose
from vrcomfort.gpu import gl
from vrcomfort.gpu.passes import AnyTexture, draw_part, part
from vrcomfort.gpu.visible_area import VisibleArea
from vrcomfort.optics.focus import Centre, GazeFollower
from vrcomfort.protocol.conditions import CentredEffect, Condition
from vrcomfort.protocol.viewing import DepthMode
from vrcomfort.render.camera import EyeCamera, Lens, PreviousCamera
from vrcomfort.render.display import noise_texture, tone_map_pass
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass, LensViews
from vrcomfort.render.effects.depth_of_field.seen_depth import SeenDepthPass
from vrcomfort.render.effects.effect import (
    Adjustable,
    EffectInputs,
    EffectPass,
    EyeFrame,
    RegisteredEffect,
)
from vrcomfort.render.focus.autofocus_zone import screen_tangents
from vrcomfort.render.focus.rays import GazeHits
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.focus.search import FocusPass, HeadView
from vrcomfort.render.graph import in_order, plan_passes
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Scene


def head_from_gaze(frame: Frame) -> Gaze | None:
    """Return a frame's gaze in the head's frame."""
    if frame.gaze is None:
        return None
    return Gaze(frame.head_pose.inverse() @ frame.gaze.pose, frame.gaze.valid)


class EyeImages(NamedTuple):
    """The textures of an eye; they hold its images until another is drawn.

    `pinhole` and `linear` are linear HDR light before and after the effects, `depth` is reverse-Z
    with `near_m`, `headset_depth` what a runtime is to get of it, `velocity` is px per frame,
    `encoded` is the display's image. `previous` is where the eye counts as having been. `gl.read`
    returns the texels of any of them; moderngl's own `read` knows no layers of depth.
    """

    camera: EyeCamera
    previous: PreviousCamera
    pinhole: moderngl.Texture
    linear: moderngl.Texture
    depth: moderngl.Texture
    headset_depth: moderngl.Texture
    velocity: moderngl.Texture | None
    encoded: moderngl.Texture


NO_EYE_TRACKER = (
    "effects are centred on the gaze (gaze_centre), and this headset has no eye tracker; use one "
    'that has, or write without_gaze = "head" under [conditions.gaze_centre]'
)
RESOLVE = "resolve"
"""Name of the part of a frame that makes one sample of several: effects may add to it."""


class ConditionPasses:
    """The passes of one condition in one scene, wired by their textures.

    Effects are drawn in the condition's order, each from the result of the one before. With several
    views through the lens, the effects up to depth of field are drawn in each view (motion blur
    along its own velocities), and the others once, on the mean of the views, with the depth and the
    velocity of the centre view, which is drawn last: its colour, depth and velocity are the eye's.

    Attributes
    ----------
    area
        The tiles that are drawn; None where no lens hides anything.
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
        headset_depth: DepthMode = "scene",
        hidden: HiddenAreas = (None, None),
    ) -> None:
        self._ctx = ctx
        self.area = None if hidden == (None, None) else VisibleArea(size_px, hidden)
        self._size_px = size_px
        self._at_once = eyes if gl.eyes_at_once(ctx) else 1
        """How many eyes passes draw at once: without layers one after the other."""
        planned = plan_passes(scene, condition)
        self.names = tuple(item.name for item in planned if item.needed)
        registered = [each for each in in_order(condition) if each.name in self.names]
        blur = condition.depth_of_field if "depth_of_field" in self.names else None
        self._views = blur.views if blur is not None else 1
        with self._limiting():
            self.scene = ScenePass(
                ctx,
                scene,
                size_px,
                velocity="velocity" in self.names,
                samples=samples,
                lens_law="dioptre" if self._views > 1 else None,
                background=condition if "background_blur" in self.names else None,
                eyes=self._at_once,
            )
        self._near_m = near_m
        self._sees_along_ray = blur is not None and blur.distance_along == "ray"
        self.focus: FocusPass | None = None
        if any("focus" in each.reads for each in registered):
            gpu, along_ray = self.scene.gpu, self._sees_along_ray
            self.focus = make_focus_pass(
                ctx, gpu, condition.focus, near_m=near_m, along_ray=along_ray
            )
        self._centred = condition.centred_on_gaze
        self._centre: GazeFollower | None = None
        if condition.gaze_centre is not None and self._centred:
            self._centre = GazeFollower(condition.gaze_centre.hold_s)
            self._needs_gaze = condition.gaze_centre.without_gaze == "stop"
        self.gaze_hits: GazeHits | None = None
        """Made when the first gaze is to be looked along."""
        self.colour = self.scene.colour
        self._pinhole: AnyTexture | None = None
        """A copy of `scene.colour` before effects, where one overwrites it and it is wanted."""
        self._lens_views: LensViews | None = None
        self._of_view: dict[str, EffectPass] = {}
        """By name, drawn in each view through the lens."""
        self._of_eye: dict[str, EffectPass] = {}
        """Drawn once."""
        self._views_of_layers: dict[tuple[int, int], moderngl.Texture] = {}
        self._seen_depth: SeenDepthPass | None = None
        with self._limiting():
            for each in registered:
                self._add(each, condition)
            self._effects: Mapping[str, EffectPass] = self._of_view | self._of_eye
            if headset_depth == "blur_aware" and blur is not None:
                self._seen_depth = SeenDepthPass(self._inputs(condition, blur, ("depth", "focus")))
            tone_map = partial(
                tone_map_pass,
                ctx,
                radiance=self.colour,
                blue_noise=noise_texture(ctx),
                size_px=size_px,
                exposure=scene.environment.exposure,
            )
            # A target for each eye: both images of a frame are valid until the next frame.
            self._tone_maps = tuple(tone_map() for _ in range(0, eyes, self._at_once))
        self.encoded = tuple(
            gl.of_eye(each.target, image)
            for each in self._tone_maps
            for image in range(self._at_once)
        )
        """Each eye's image for the display, until the next frame."""

    def _limiting(self) -> AbstractContextManager[None]:
        """Return the context in which passes of an eye's image are made."""
        return nullcontext() if self.area is None else self.area.limiting()

    def _add(self, registered: RegisteredEffect, condition: Condition) -> None:
        settings = getattr(condition, registered.name)
        effect = registered.build(self._inputs(condition, settings, registered.reads))
        if effect is not None:
            self._of_eye[registered.name] = effect
            self.colour = effect.target
        if registered.name == "depth_of_field":
            self._add_lens_views(condition)

    def _inputs(self, condition: Condition, settings: Any, reads: Iterable[str]) -> EffectInputs:
        focus = self.focus.texture if self.focus is not None else None
        made = {"depth": self.scene.depth, "focus": focus, "velocity": self.scene.velocity}
        return EffectInputs(
            self._ctx,
            settings,
            self.colour,
            {name: found for name in reads if (found := made.get(name)) is not None},
            condition.focus.infinity_m,
            # Only the first effect reads the scene's own image: there the resolve writes radii.
            self.scene if self.colour is self.scene.colour else None,
        )

    def _add_lens_views(self, condition: Condition) -> None:
        settings = condition.depth_of_field
        if settings is None or self.focus is None or self._views == 1:
            return
        # The effects so far are drawn in each view, those to come once, on the mean.
        self._of_view, self._of_eye = self._of_eye, {}
        self.scene.lens_focus = self.focus.texture
        infinity_m = condition.focus.infinity_m
        self._lens_views = LensViews(self._ctx, self.colour, settings, infinity_m)
        self.colour = self._lens_views.target

    def leave_out_records(self) -> None:
        """Draw nothing from now on that serves only the record of limits: for measurements."""
        for effect in self._effects.values():
            if isinstance(effect, DepthOfFieldPass):
                effect.leave_out_records()

    def warm_up(self) -> None:
        """Draw once the passes that frames without motion skip, so that they are compiled."""
        for effect in self._effects.values():
            effect.warm_up()

    @property
    def max_blur_px(self) -> float | None:
        """Return the largest radius or half streak there can be; None: views have no limit."""
        if self._lens_views is not None:
            return None
        return max((effect.max_radius_px for effect in self._effects.values()), default=0.0)

    def clamps(self) -> tuple[str, ...]:
        """Return which limits have shortened a blur so far, in words; waits for the GPU."""
        return tuple(
            clamp for name, effect in self._effects.items() for clamp in self._clamps(name, effect)
        )

    def _clamps(self, name: str, effect: EffectPass) -> tuple[str, ...]:
        clamps = effect.clamps()
        if self._lens_views is None or name != "depth_of_field":
            return clamps
        views = f"in each of {self._lens_views.views} views through the lens"
        return tuple(f"{clamp} {views}; their mean has no limit" for clamp in clamps)

    def reset(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        for effect in self._effects.values():
            effect.reset()
        if self._centre is not None:
            self._centre.reset()

    def centre(self, frame: Frame) -> Centre | None:
        """Return the centre of gaze-contingent effects; None without such effects.

        Raises
        ------
        InputError
            Without an eye tracker, where the condition needs one.
        """
        if self._centre is None:
            return None
        if frame.gaze is None and self._needs_gaze:
            raise InputError(NO_EYE_TRACKER)
        return self._centre.at(head_from_gaze(frame), frame.predicted_display_time_ns)

    def axis(self, name: CentredEffect, centre: Centre | None) -> Array | None:
        """Return the direction that an effect is centred on; None: the head's forward axis."""
        return centre.direction if centre is not None and name in self._centred else None

    def look_along(self, frame: Frame, world_from_head: Pose) -> tuple[bool, tuple[GazeHit, ...]]:
        """Find the surface that the gaze of a frame hits.

        Return whether it is known where it looks, and the hits of earlier frames that have arrived.
        """
        gaze = head_from_gaze(frame)
        if gaze is None:
            return False, ()
        if self.gaze_hits is None:
            self.gaze_hits = GazeHits(
                self._ctx, self.scene.gpu, near_m=self._near_m, along_ray=self._sees_along_ray
            )
        hits = self.gaze_hits.look(frame.index, gaze, world_from_head)
        return self.gaze_hits.sought, hits

    def adjust(self, condition: Condition) -> None:
        """Draw by other settings from now on: those that can change while passes are there."""
        for name, effect in self._effects.items():
            effect.adjust(condition, getattr(condition, name))
        if self._seen_depth is not None and condition.depth_of_field is not None:
            self._seen_depth.adjust(condition.depth_of_field, condition.focus.infinity_m)
        focus: object = self.focus
        if isinstance(focus, Adjustable):
            focus.adjust(condition.focus)

    def find_focus(
        self, frame: Frame, world_from_head: Pose, scene_time_s: float, centre: Centre | None = None
    ) -> tuple[FocusSample, ...]:
        """Decide the focus of both eyes, and return the samples that have arrived."""
        if self.focus is None:
            return ()
        view = HeadView(
            frame.index,
            frame.predicted_display_time_ns,
            world_from_head,
            frame.discontinuity,
            screen_tangents(frame.views),
            head_from_gaze(frame),
            scene_time_s,
            centre.tangents if centre and "autofocus_zone" in self._centred else (0.0, 0.0),
        )
        return draw_part("focus", self.focus.render, view)

    def place(self, eyes: Sequence[EyeFrame], scene_time_s: float) -> None:
        """Move the scene to a time, and place it for all eyes of a frame at once."""
        cameras, previous = [eye.camera for eye in eyes], [eye.previous for eye in eyes]
        head = cameras[0].head
        self.scene.update(scene_time_s, head, previous[0].time_s, cameras, previous)

    def render(
        self,
        eyes: Sequence[EyeFrame],
        scene_time_s: float,
        on_eye: Callable[[int, EyeImages], None] | None = None,
        *,
        keep_pinhole: bool = False,
    ) -> None:
        """Draw the eyes of a frame and their effects.

        Passes draw both eyes at once; without layers the left eye goes through all of them first.

        Parameters
        ----------
        on_eye
            Called with each eye (0 left, 1 right) and its textures.
        keep_pinhole
            Whether `EyeImages.pinhole` is looked at.
        """
        blur = self._of_eye.get("depth_of_field")
        keep = keep_pinhole and isinstance(blur, DepthOfFieldPass) and blur.draws_behind
        if keep and self._pinhole is None:
            self._pinhole = gl.eye_texture(self._ctx, self._size_px, self._at_once)
        for first in range(0, len(eyes), self._at_once):
            now = eyes[first : first + self._at_once]
            self._render(now, scene_time_s, keep_pinhole=keep)
            if on_eye is not None:
                for image, eye in enumerate(now):
                    on_eye(eye.eye_index, self._images(eye, image, keep_pinhole=keep))

    def _render(self, eyes: Sequence[EyeFrame], scene_time_s: float, *, keep_pinhole: bool) -> None:
        if self._lens_views is not None:
            with part("lens_views"):
                self._lens_views.render(
                    [eye.camera.fov for eye in eyes],
                    lambda lenses: self._draw(eyes, self._of_view, scene_time_s, lenses),
                )
        # The centre view comes last: its depth and velocity are those of the eye.
        self._draw(eyes, self._of_eye, scene_time_s, keep_pinhole=keep_pinhole)
        tone_map = self._tone_maps[eyes[0].eye_index]
        draw_part("tone_map", tone_map.render)
        if self._seen_depth is not None:
            cameras = [eye.camera for eye in eyes]
            draw_part("headset_depth", self._seen_depth.render, *cameras)

    def _draw(
        self,
        eyes: Sequence[EyeFrame],
        effects: Mapping[str, EffectPass],
        scene_time_s: float,
        lenses: Sequence[Lens | None] = (None, None),
        *,
        keep_pinhole: bool = False,
    ) -> None:
        seen, scene = [], self.scene
        for image, (eye, lens) in enumerate(zip(eyes, lenses, strict=False)):
            if self.area is not None:
                self.area.eye = eye.eye_index
            camera, previous = eye.camera, eye.previous
            camera = camera if lens is None else replace(camera, lens=lens)
            of_image: dict[str, Any] = {"resolve": False, "image": image}
            draw_part("scene", scene.render, camera, scene_time_s, previous, **of_image)
            draw_part(RESOLVE, scene.resolve.render, camera, image)
            seen.append(eye._replace(still=scene.still))
        if keep_pinhole and self._pinhole is not None:
            gl.copier(self._ctx, scene.colour, self._pinhole)()
        for name, effect in effects.items():
            draw_part(name, effect.render, *seen)

    def _images(self, eye: EyeFrame, image: int, *, keep_pinhole: bool) -> EyeImages:
        scene, seen_depth = self.scene, self._seen_depth
        kept = self._pinhole if keep_pinhole else None
        return EyeImages(
            eye.camera,
            eye.previous,
            self._alone(scene.colour if kept is None else kept, image),
            self._alone(self.colour, image),
            self._alone(scene.depth, image),
            self._alone(scene.depth if seen_depth is None else seen_depth.target, image),
            None if scene.velocity is None else self._alone(scene.velocity, image),
            self.encoded[eye.eye_index],
        )

    def _alone(self, texture: AnyTexture, image: int) -> moderngl.Texture:
        key = texture.glo, image
        if key not in self._views_of_layers:
            self._views_of_layers[key] = gl.of_eye(texture, image)
        return self._views_of_layers[key]
