"""Motion blur of each eye from a velocity buffer (McGuire et al. 2012, Guertin et al. 2013).

::

    velocity ─► TileMaxPass ─► ReductionPass    longest streak and kind of the frame, in one texel
                    │              │
                dilation ◄─────────┤            tiles that streaks reach, and their class
                    │              ▼
                    │          averages         along each pixel's own streak, in one step or two
                    ▼              ▼
                complex tiles ─► target         occlusion at velocity discontinuities

The CPU never learns how long a frame's streaks are: the vertex shaders of passes that a frame does
not need give triangles without area. ``docs/motion_blur.md`` tells more.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

import moderngl
import numpy as np

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, ReductionPass, copier
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.gpu.shaders import Defines
from vrcomfort.optics.motion import Sampling, ramp, sampling_of
from vrcomfort.protocol.conditions import Condition, MotionBlur
from vrcomfort.render.camera import HeadStep
from vrcomfort.render.effects.effect import EffectInputs, EffectPass, EyeFrame, RegisteredEffect
from vrcomfort.scene.data import Scene


def decide(settings: MotionBlur, _: Condition, scene: Scene) -> tuple[bool, str]:
    """Say whether there is motion blur; a shutter that never opens for long blurs nothing.

    Locomotion and heads move at run time, so only a mode that ignores every camera can be known
    to see nothing move; frames in which nothing moved are copied without any pass in every mode.
    """
    if settings.shutter_fraction == 0:
        return False, "its shutter is open for no time"
    turns = settings.virtual_turning == "kept"
    moves = scene.has_hands or any(node.moving for node in scene.nodes)
    if settings.mode == "objects_only" and not turns and not moves:
        return False, "objects_only, and nothing in the scene moves"
    reason = f"{settings.mode}, shutter open for {settings.shutter_fraction:g} of the frame"
    if settings.neck is not None and settings.mode == "rotation_cancelled":
        reason += f", about a neck {settings.neck.behind_m:g} m behind"
        reason += f" and {settings.neck.below_m:g} m below the eyes"
    if settings.virtual_turning != "by_mode":
        reason += f", virtual turning {settings.virtual_turning}"
    return True, reason


def streak_scale(settings: MotionBlur, step: HeadStep | None) -> float:
    """Return the factor of all streaks, 1 to 0.

    The shutter is open for a part of one period, also where the frame before lies further back;
    and streaks may fade for how fast the head turns.
    """
    if step is None:
        return 1.0
    fade = settings.fade_with_turning
    faded = ramp(step.turn_deg_s("head"), fade.from_deg_s, fade.to_deg_s) if fade else 0.0
    return (1 - faded) / step.periods


class MotionBlurPass(EffectPass):
    """Smears the image along its velocity for as long as the shutter is open.

    Notes
    -----
    The limit on half streaks alters what is seen. :meth:`clamps` says how long those would have
    been that were shortened to ``max_radius_px``.
    """

    settings: MotionBlur

    def __init__(self, inputs: EffectInputs) -> None:
        super().__init__(inputs)
        ctx, colour, velocity = inputs.ctx, inputs.colour, inputs.reads["velocity"]
        samples, max_percent = self.settings.samples, self.settings.max_radius_percent
        self._max_radius_px = max_radius_px = max_percent / 100 * inputs.size_px[0]
        self._method: Reconstruction | PerPixel
        if self.settings.method == "reconstruction":
            self._method = Reconstruction(
                ctx,
                colour=colour,
                depth=inputs.reads["depth"],
                velocity=velocity,
                samples=samples,
                max_radius_px=max_radius_px,
            )
        else:
            self._method = PerPixel(
                ctx, colour=colour, velocity=velocity, samples=samples, max_radius_px=max_radius_px
            )
        self.target = self._method.target
        self._copy = copier(ctx, colour, self.target)

    @property
    def max_radius_px(self) -> float:
        """Return the limit on half streaks."""
        return self._max_radius_px

    def render(self, *eyes: EyeFrame) -> None:
        """Blur the present image; where nothing has moved, it is copied, bit by bit."""
        scale = streak_scale(self.settings, eyes[0].step)
        if all(eye.still for eye in eyes) or scale == 0:
            self._copy()
            return
        self._draw(scale)

    def warm_up(self) -> None:
        """Draw everything once, which frames in which nothing moves leave out."""
        self._draw(0.0)

    def _draw(self, scale: float) -> None:
        self._method.render(self.settings.shutter_fraction * scale)

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU.

        With ``per_pixel``, of those only that the limit has shortened; 0 where there are none.
        """
        return self._method.longest_half_velocity_px()

    def clamps(self) -> tuple[str, ...]:
        """Return the limit's effect on the frames so far, in words; waits for the GPU."""
        longest_px = self.longest_half_velocity_px()
        if longest_px <= self.max_radius_px:
            return ()
        return (
            f"motion blur: half streaks of up to {longest_px:.1f} px were shortened to "
            f"{self.max_radius_px:.1f} px",
        )


EFFECT = RegisteredEffect(
    "motion_blur", decide, MotionBlurPass, reads=frozenset({"depth", "velocity"})
)


class Reconstruction:
    """Averages along each pixel's own streak; compares depth at velocity discontinuities.

    Parameters
    ----------
    colour, depth, velocity
        Linear HDR RGBA16F, reverse-Z D32F and RG16F (px per frame, +x right, +y up).
    samples
        As in ``MotionBlur.samples``.
    max_radius_px
        No half streak is longer.

    Notes
    -----
    A frame whose longest streak is short is averaged in one step, others in two; only tiles with
    velocity discontinuities compare depth.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: AnyTexture,
        depth: AnyTexture,
        velocity: AnyTexture,
        samples: int,
        max_radius_px: float,
    ) -> None:
        self._ctx, self._colour, self._velocity = ctx, colour, velocity
        self._max_radius_px = max_radius_px
        self._limit = {"max_radius_px": max_radius_px}
        self._sampling = sampling = sampling_of(samples, colour.width)
        self._tile_max = TileMaxPass(
            ctx, velocity=velocity, max_radius_px=max_radius_px, sampling=sampling
        )
        self._dilate = _dilation(ctx, self._tile_max, max_radius_px, sampling.jump)
        size_px, eyes = gl.size_px_of(colour), gl.layers_of(colour)
        self.target = gl.eye_texture(ctx, size_px, eyes)
        kinds = {
            "LONG": (1, 1),
            **({"LONG_X": (2, 1), "LONG_Y": (1, 2)} if sampling.halves else {}),
        }
        self._averages = (
            *(each for kind, px in kinds.items() for each in self._two_steps(kind, px)),
            self._average("motion_blur", colour, "SHORT", max_radius_px, {"PAIRS": sampling.pairs}),
        )
        self._foreground = self._complex_tiles(depth)

    def _two_steps(self, kind: str, px: tuple[int, int]) -> Iterator[FullscreenPass]:
        """Yield the two steps in frames of a kind, where an average is of `px` pixels."""
        sampling, source, rest_px = self._sampling, self._colour, self._max_radius_px
        halved: Defines = {"HALVED": 1} if max(px) > 1 else {}
        per = f"vec2({px[0]}.0, {px[1]}.0)"
        defines: Defines
        if sampling.taps > 1:
            part_px = rest_px / sampling.parts
            samples = {"SAMPLES": sampling.taps, "PARTS": sampling.parts}
            defines = {**samples, "PX_PER_AVERAGE": per, **halved}
            average = self._average("streak_average", source, kind, part_px, defines, px)
            yield average
            source, rest_px = average.target, rest_px - part_px
        defines = {"SAMPLES": sampling.parts, "PARTS": 1, "PX_PER_TEXEL": per, **halved}
        yield self._average("streak_average", source, kind, rest_px, defines)

    def _average(
        self,
        name: str,
        source: AnyTexture,
        kind: str,
        reach_px: float,
        defines: Defines,
        px: tuple[int, int] | None = None,
    ) -> FullscreenPass:
        """Return a pass over the image in frames of a kind, into `target` where no `px` is."""
        width, height = gl.size_px_of(self._colour)
        across, up = px or (1, 1)
        return FullscreenPass(
            self._ctx,
            f"motion_blur/{name}.frag",
            size_px=(ceil(width / across), ceil(height / up)),
            inputs={
                "frame": self._tile_max.frame.target,
                "velocity": self._velocity,
                "source": source,
            },
            filtered={"source"},
            constants=self._limit,
            defines={
                **self._tile_max.frame_defines,
                **defines,
                "KIND": kind,
                **({"CUBIC": 1} if self._sampling.cubic else {}),
            },
            vertex="motion_blur/frame_of_streaks.vert",
            target=None if px else self.target,
            reach_px={"velocity": 0.0, "source": reach_px + ACROSS_PX},
            texel_px=(across, up),
        )

    def _complex_tiles(self, depth: AnyTexture) -> FullscreenPass:
        longest, crossing = self._dilate.targets
        tile_px = self._tile_max.tile_px
        most_taps = self._sampling.most_taps
        stride_px = max(self._sampling.stride_px, self._max_radius_px / most_taps + 2)
        reach_px = self._max_radius_px + 2 * stride_px + 1
        return FullscreenPass(
            self._ctx,
            "motion_blur/motion_blur_foreground.frag",
            size_px=gl.size_px_of(self._colour),
            inputs={
                "colour": self._colour,
                "velocity": self._velocity,
                "depth": depth,
                "longest": longest,
                "crossing": crossing,
                "frame": self._tile_max.frame.target,
            },
            filtered={"colour"},
            constants=self._limit,
            defines={
                "JUMP": self._sampling.jump,
                "TILE": tile_px,
                "POINT_PX": tile_px,
                "CLASS": "COMPLEX",
                "STRIDE": self._sampling.stride_px,
                "MOST_TAPS": most_taps,
            },
            vertex="motion_blur/motion_tiles_of_class.vert",
            tiles=gl.size_px_of(longest),
            target=self.target,
            reach_px={
                **dict.fromkeys(("colour", "velocity", "depth"), reach_px),
                **dict.fromkeys(("longest", "crossing"), 0.0),
            },
        )

    @property
    def tiles(self) -> tuple[AnyTexture, AnyTexture]:
        """Return the streaks that reach each tile with its class, and those that cross it.

        Of the last frame that may have had velocity discontinuities.
        """
        longest, crossing = self._dilate.targets
        return longest, crossing

    def render(self, shutter_fraction: float) -> None:
        """Blur along the present streaks; the shutter is open for this part of a frame period."""
        self._tile_max.render(shutter_fraction)
        self._dilate.render()
        for each in (*self._averages, self._foreground):
            each.render(shutter_fraction=shutter_fraction)

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU."""
        return self._tile_max.frame.read()


def _dilation(
    ctx: moderngl.Context, tile_max: TileMaxPass, max_radius_px: float, jump: float
) -> FullscreenPass:
    tile_px = tile_max.tile_px
    return FullscreenPass(
        ctx,
        "motion_blur/tile_max_dilate.frag",
        size_px=gl.size_px_of(tile_max.target),
        inputs={
            "tile_max": tile_max.target,
            "tile_max_crossing": tile_max.crossing,
            "frame": tile_max.frame.target,
        },
        more_components=(2,),
        constants={"max_radius_px": max_radius_px},
        defines={**tile_max.frame_defines, "TILE": tile_px, "JUMP": jump, "PASSING": 1},
        vertex="motion_blur/frame_of_streaks.vert",
        reach_px=dict.fromkeys(("tile_max", "tile_max_crossing"), max_radius_px + tile_px),
        texel_px=(tile_px, tile_px),
    )


ACROSS_PX = 3.0
"""How far beside a streak its reads go: two rows and the filter."""
LEAST_TILE_PX = 16
MOST_TILES = 8
"""Tiles that the longest half velocity may cross: more are finer, and more to look at."""
ROWS = 4
"""Rows of pixels that are summed up first; a tile has a multiple of them."""
AT_ONCE_PX = 400
"""Images up to so wide have few tiles: each is summed up at once."""


class TileMaxPass:
    """Sums up by tile how far points move while the shutter is open.

    Parameters
    ----------
    velocity
        RG16F (px per frame, +x right, +y up).
    max_radius_px
        No half velocity counts for more.
    sampling
        How streaks are averaged: says of what kind a frame is.

    Attributes
    ----------
    target, crossing
        RGBA16F and RG16F, see ``tile_max.frag``; one texel for `tile_px` pixels each way.
    frame
        The streaks of the whole frame: ``frame_streaks.comp``.
    frame_defines
        Those of ``frame_kinds.glsl``.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        velocity: AnyTexture,
        max_radius_px: float,
        sampling: Sampling,
    ) -> None:
        width, height = gl.size_px_of(velocity)
        self.tile_px = max(LEAST_TILE_PX, ROWS * ceil(max_radius_px / MOST_TILES / ROWS))
        at_once = width <= AT_ONCE_PX and self.tile_px == LEAST_TILE_PX
        rows = self.tile_px if at_once else ROWS
        self._strips = FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(ceil(width / self.tile_px), ceil(height / rows)),
            inputs={"velocity": velocity},
            more_components=(2,),
            defines={"TILE": self.tile_px, "ROWS": rows, "JUMP": sampling.jump},
            reach_px=1.0,
            texel_px=(self.tile_px, rows),
        )
        self._tiles = None if at_once else self._of_strips(ctx, height)
        self.target, self.crossing = (self._tiles or self._strips).targets
        self.frame_defines: Defines = {
            "ONE_STEP_PX": sampling.one_step_px,
            "HALVES": int(sampling.halves),
        }
        self.frame = ReductionPass(
            ctx,
            "motion_blur/frame_streaks.comp",
            ("tile_max", self.target),
            texel_px=(self.tile_px, self.tile_px),
            components=4,
            defines=self.frame_defines,
            constants={"max_radius_px": max_radius_px},
        )

    def _of_strips(self, ctx: moderngl.Context, height: int) -> FullscreenPass:
        strips = self._strips.targets
        return FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(strips[0].width, ceil(height / self.tile_px)),
            inputs=dict(zip(("source", "source_crossing"), strips, strict=True)),
            more_components=(2,),
            defines={"STRIPS": self.tile_px // ROWS},
            reach_px=0.0,
            texel_px=(self.tile_px, self.tile_px),
        )

    def render(self, shutter_fraction: float) -> None:
        """Find the present streaks; the shutter is open for this part of a frame period."""
        self._strips.render(shutter_fraction=shutter_fraction)
        if self._tiles is not None:
            self._tiles.render()
        self.frame.render()


_LONGEST_BINDING = 0


class PerPixel:
    """Averages `samples` along each pixel's own streak into `target`: one pass (Rosado 2007).

    For comparison with ours: streaks end at the silhouette edges of moving objects.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: AnyTexture,
        velocity: AnyTexture,
        samples: int,
        max_radius_px: float,
    ) -> None:
        self._ctx = ctx
        # Maximum by atomics on the bits: positive floats have the order of their bits.
        self._longest = gl.dynamic_buffer(ctx, 4)
        self._longest.clear()
        self._gather = FullscreenPass(
            ctx,
            "motion_blur/motion_blur_per_pixel.frag",
            size_px=gl.size_px_of(colour),
            inputs={"colour": colour, "velocity": velocity},
            filtered={"colour"},
            reach_px={"colour": max_radius_px + 1, "velocity": 0.0},
            constants={"max_radius_px": max_radius_px},
            defines={"SAMPLES": samples, "LONGEST_BINDING": _LONGEST_BINDING},
        )
        self.target = self._gather.target

    def render(self, shutter_fraction: float) -> None:
        """Blur along the present streaks."""
        self._longest.bind_to_storage_buffer(_LONGEST_BINDING)
        self._gather.render(shutter_fraction=shutter_fraction)

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak that was shortened, 0 where none was; waits."""
        self._ctx.memory_barrier()
        return float(np.frombuffer(self._longest.read(), np.float32)[0])
