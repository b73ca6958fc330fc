"""A full-screen pass draws with the uniforms and textures it is given, whatever came before."""

import numpy as np

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.render.display import TONE_CURVE, noise_texture
from vrcomfort.render.output import read_texture

SIZE = (2, 2)


def gray(ctx, level):
    texture = gl.color_texture(ctx, SIZE)
    texture.write(np.full((2, 2, 4), level, np.float16).tobytes())
    return texture


def encoder(ctx, radiance):
    return FullscreenPass(
        ctx, "display/tone_map.frag", size_px=SIZE,
        inputs={"radiance": radiance, "blue_noise": noise_texture(ctx)},
        defines=TONE_CURVE, dtype="f1",
    )  # fmt: skip


def test_a_uniform_has_the_value_that_was_given_last(ctx):
    drawn = encoder(ctx, gray(ctx, 0.25))

    def level(**uniforms):
        drawn.render(**uniforms)
        return int(read_texture(drawn.target)[0, 0, 0])

    dark, bright = level(exposure=0.5), level(exposure=1.5)
    assert dark < bright
    assert level(exposure=0.5) == dark
    assert level() == dark
    assert level(exposure=1.5) == bright


def test_passes_that_take_turns_keep_their_textures(ctx):
    passes = [encoder(ctx, gray(ctx, level)) for level in (0.1, 0.4)]
    for _ in range(2):
        for each in passes:
            each.render(exposure=1.0)
        dark, bright = (int(read_texture(each.target)[0, 0, 0]) for each in passes)
        assert 0 < dark < bright
