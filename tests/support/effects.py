"""Synthetic images and one-call blurs that the effect tests share."""

import numpy as np

from vrcomfort.geometry import Fov, Pose
from vrcomfort.gpu import gl
from vrcomfort.protocol.conditions import DepthOfField, MotionBlur
from vrcomfort.render.camera import EyeCamera, PreviousCamera
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.effect import EffectInputs, EyeFrame
from vrcomfort.render.effects.motion_blur import MotionBlurPass

NEAR_M = 0.02


def textures(ctx, rgb, distance_m, near_m=NEAR_M):
    """Return colour and depth textures of (h, w, 3) radiance and (h, w) distances, inf for sky."""
    size_px = rgb.shape[1], rgb.shape[0]
    colour, depth = gl.color_texture(ctx, size_px), gl.depth_texture(ctx, size_px)
    write_scene(colour, depth, rgb, distance_m, near_m)
    return colour, depth


def write_scene(colour, depth, rgb, distance_m, near_m=NEAR_M):
    """Write radiance and distances into textures of their size."""
    height, width, _ = rgb.shape
    alpha = np.ones((height, width, 1))
    colour.write(np.concatenate([rgb, alpha], axis=-1).astype("f2").tobytes())
    distance = np.broadcast_to(np.asarray(distance_m, float), (height, width))
    with np.errstate(divide="ignore"):
        depth.write((near_m / distance).astype("f4").tobytes())


def coc_passes_of(ctx, settings, distance_m, focus_m, size_px):
    """Return what finds the radii of (h, w) distances, before its first frame."""
    width, height = size_px
    colour, depth = textures(ctx, np.zeros((height, width, 3)), distance_m)
    focus = ctx.texture((1, 1), 4, np.full(4, focus_m, "f4").tobytes(), dtype="f4")
    reads = {"depth": depth, "focus": focus}
    return CocPasses(EffectInputs(ctx, settings, colour, reads, 3e4))


def texels_of(texture):
    """Return (h, w, components) of a texture of floats, as they are in it."""
    width, height = texture.size
    values = np.frombuffer(texture.read(), texture.dtype).reshape(height, width, -1)
    return values.astype(np.float64)


def rgb_of(texture):
    """Return (h, w, 3) half floats as they are in a texture."""
    width, height = texture.size
    return np.frombuffer(texture.read(), "f2").reshape(height, width, 4)[..., :3]


def square_pixels(size_px):
    return Fov.symmetric(vertical_rad=1.6, aspect=size_px[0] / size_px[1])


def seen(fov=None, *, near_m=NEAR_M, head_from_eye=None, eye_index=0, time_ns=0, **known):
    """Return what an effect is told of an eye whose head rests at the origin."""
    head_from_eye = head_from_eye or Pose()
    camera = EyeCamera(head_from_eye, fov or square_pixels((1, 1)), near_m, Pose())
    known.setdefault("previous", PreviousCamera(head_from_eye, 0.0))
    return EyeFrame(eye_index, time_ns, head_from_eye, camera, **known)


class Lens:
    """Depth of field at one size, for as many images as a test has."""

    def __init__(self, ctx, size_px, **settings):
        self._colour, self._depth = gl.color_texture(ctx, size_px), gl.depth_texture(ctx, size_px)
        self._focus = ctx.texture((1, 1), 4, dtype="f4")
        self._size_px = size_px
        reads = {"depth": self._depth, "focus": self._focus}
        self._effect = DepthOfFieldPass(
            EffectInputs(ctx, DepthOfField(**settings), self._colour, reads)
        )

    def blur(self, rgb, distance_m, focus_m, *, near_m=NEAR_M, fov=None, eye=None):
        """Return the (h, w, 3) blurred image."""
        write_scene(self._colour, self._depth, rgb, distance_m, near_m)
        self._focus.write(np.full(4, focus_m, "f4").tobytes())
        fov = fov or square_pixels(self._size_px)
        self._effect.render(seen(fov, near_m=near_m, head_from_eye=eye))
        return rgb_of(self._effect.target)


def depth_of_field(ctx, rgb, distance_m, focus_m, *, near_m=NEAR_M, fov=None, eye=None, **settings):
    """Return the (h, w, 3) blurred image."""
    lens = Lens(ctx, (rgb.shape[1], rgb.shape[0]), **settings)
    return lens.blur(rgb, distance_m, focus_m, near_m=near_m, fov=fov, eye=eye)


def motion_blur_pass(ctx, rgb, distance_m, velocity, *, step=None, **settings):
    size_px = rgb.shape[1], rgb.shape[0]
    colour, depth = textures(ctx, rgb, distance_m)
    buffer = gl.color_texture(ctx, size_px, components=2)
    with np.errstate(over="ignore"):
        field = np.broadcast_to(velocity, (*rgb.shape[:2], 2)).astype("f2")
    buffer.write(field.tobytes())
    reads = {"depth": depth, "velocity": buffer}
    effect = MotionBlurPass(EffectInputs(ctx, MotionBlur(**settings), colour, reads))
    effect.render(seen(step=step))
    return effect


def motion_blur(ctx, rgb, distance_m, velocity, **settings):
    """Return the (h, w, 3) blurred image."""
    return rgb_of(motion_blur_pass(ctx, rgb, distance_m, velocity, **settings).target)
