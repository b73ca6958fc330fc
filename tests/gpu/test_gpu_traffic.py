"""Texture reads, bytes, draws and passes of passes that are known."""

import moderngl
import numpy as np
import pytest

from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, max_reduction
from vrcomfort.gpu.passes import Pass, PassImage, check_order, watched
from vrcomfort.gpu.shaders import with_counted_reads
from vrcomfort.gpu.traffic import DrawnPass, TrafficCounter, added_up

SIZE = (12, 10)
PIXELS = 120
COPY = "depth_of_field/scaled_copy.frag"


def fullscreen(ctx, fragment, source, name="source", size_px=SIZE, **options):
    with shaders.counting_reads():
        return FullscreenPass(ctx, fragment, size_px=size_px, inputs={name: source}, **options)


def counted(ctx, *draws):
    counter = TrafficCounter(ctx)
    with watched(counter):
        for draw in draws:
            draw()
    return counter.drawn


def test_a_copy_reads_each_pixel_once_and_writes_it(ctx):
    source = gl.color_texture(ctx, SIZE)
    (drawn,) = counted(ctx, fullscreen(ctx, COPY, source, "image").render)
    assert (drawn.declared.name, drawn.samples, drawn.reads) == (COPY, PIXELS, PIXELS)
    assert drawn.bytes == PIXELS * (8 + 8)


def test_loops_and_filters_are_counted_by_call(ctx):
    source = gl.color_texture(ctx, SIZE)
    tent = fullscreen(ctx, "depth_of_field/tent.frag", source, filtered={"source"})
    cells = fullscreen(
        ctx,
        "depth_of_field/poisson15_near_mean.frag",
        source,
        "colour_and_coc",
        size_px=(2, 2),
        defines={"CELL": 8},
        components=1,
    )
    first, second = counted(ctx, tent.render, cells.render)
    assert first.reads == 4 * PIXELS
    assert second.reads == PIXELS  # cells at the rim are smaller
    assert second.bytes == PIXELS * 8 + 4 * 2


@pytest.mark.smoke
def test_pictures_are_the_same_with_counting(ctx):
    source = gl.color_texture(ctx, SIZE)
    source.write(np.random.default_rng(1).uniform(0, 9, (10, 12, 4)).astype("f2").tobytes())
    plain = FullscreenPass(
        ctx, "depth_of_field/tent.frag", size_px=SIZE, inputs={"source": source},
        filtered={"source"},
    )  # fmt: skip
    plain.render()
    tent = fullscreen(ctx, "depth_of_field/tent.frag", source, filtered={"source"})
    counted(ctx, tent.render)
    assert plain.target.read() == tent.target.read()


def test_a_mip_chain_is_one_pass_of_many_draws(ctx):
    source, chain = gl.color_texture(ctx, (32, 32)), []
    for level in (1, 2, 3):
        chain.append(
            fullscreen(
                ctx,
                "common/mip_downsample.frag",
                source,
                size_px=(32 >> level, 32 >> level),
                constants={"size_px": (32, 32)},
                defines={"TEXEL": 2 ** (level - 1)},
            )
        )
        source = chain[-1].target
    copy = fullscreen(ctx, COPY, source, "image", size_px=(4, 4))
    found = added_up(counted(ctx, *(each.render for each in (*chain, copy))))
    assert (found.passes, found.draws) == (2, 4)
    texels = [32**2, 16**2, 8**2, 4**2]
    assert found.bytes == 8 * (texels[0] + 2 * texels[1] + 2 * texels[2] + 3 * texels[3])
    assert found.reads == texels[0] + texels[1] + texels[2] + texels[3]


def test_what_is_drawn_twice_into_the_same_target_is_one_pass(ctx):
    source, target = gl.color_texture(ctx, SIZE), gl.color_texture(ctx, SIZE)
    twice = [fullscreen(ctx, COPY, source, "image", target=target) for _ in range(2)]
    other = fullscreen(ctx, COPY, target, "image")
    assert added_up(counted(ctx, *(each.render for each in (*twice, other))))[:2] == (2, 3)
    assert added_up([]) == (0, 0, 0, None)


def test_part_of_a_target_is_part_of_the_bytes(ctx):
    source = gl.color_texture(ctx, SIZE)
    copy = fullscreen(ctx, COPY, source, "image")
    part = ctx.framebuffer([copy.target])
    part.scissor = (0, 0, 6, 5)
    copy._triangle.scope = ctx.scope(part, moderngl.NOTHING)
    (drawn,) = counted(ctx, copy.render)
    assert (drawn.samples, drawn.reads) == (30, 30)
    assert drawn.bytes == pytest.approx(30 * 16)


def test_samples_are_written_one_by_one_and_overdrawn_ones_again(ctx):
    many = gl.color_texture(ctx, SIZE, samples=4)
    source = gl.color_texture(ctx, SIZE)
    twice = [fullscreen(ctx, COPY, source, "image", target=many) for _ in range(2)]
    drawn = counted(ctx, *(each.render for each in twice))
    assert [each.samples for each in drawn] == [4 * PIXELS] * 2
    assert [each.bytes for each in drawn] == [PIXELS * (8 + 4 * 8)] * 2


def test_copies_and_clears_are_bytes_and_no_draws(ctx):
    source, target = (gl.color_texture(ctx, SIZE) for _ in range(2))
    copy = gl.copier(ctx, source, target)
    largest = max_reduction(ctx, source)
    drawn = counted(ctx, copy, largest.reset)
    copy()
    assert [(each.declared.name, each.bytes) for each in drawn] == [
        ("copy", PIXELS * 16),
        ("clear", 4),
    ]
    assert added_up(drawn) == (0, 0, PIXELS * 16 + 4, None)


def test_what_is_blended_is_read_too():
    read, written = PassImage(1, SIZE, PIXELS * 8), PassImage(2, SIZE, PIXELS * 4)
    added = Pass("added.frag", (read,), (written,), blends=True)
    assert DrawnPass(added, 1, PIXELS, 0).bytes == PIXELS * 8 + PIXELS * 2 * 4


def test_a_dispatch_reads_each_texel_once_and_draws_no_samples(ctx):
    with shaders.counting_reads():
        largest = max_reduction(ctx, gl.color_texture(ctx, SIZE))
    (drawn,) = counted(ctx, largest.render)
    assert (drawn.draws, drawn.samples, drawn.reads) == (1, 0, PIXELS + 1)
    # The texels, the maximum of all frames before and after, and that of this one.
    assert drawn.bytes == PIXELS * 8 + 3 * 4


def test_a_pass_that_reads_what_it_writes_is_refused(ctx):
    texture = gl.color_texture(ctx, SIZE)
    message = r"scaled_copy\.frag reads the 12×10 texture that it writes"
    with pytest.raises(ValueError, match=message):
        FullscreenPass(ctx, COPY, size_px=SIZE, inputs={"image": texture}, target=texture)


def test_passes_in_a_cycle_are_refused_with_both_names():
    first, second, given = (PassImage(name, (4, 4), 64) for name in (1, 2, 3))
    forth = Pass("forth.frag", (first, given), (second,))
    back = Pass("back.frag", (second,), (first,))
    message = r"forth\.frag reads a 4×4 texture that the pass back\.frag writes after it"
    with pytest.raises(ValueError, match=message):
        check_order([forth, back])
    check_order([Pass("start.frag", (), (first,)), forth, back])
    check_order([Pass("forth.frag", (), (second,), earlier=(first,)), back])


VERTEX = """#version 450 core
void main() {
    vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
    gl_Position = vec4(at, 0.5, 1.0);
}
"""
NESTED = """#version 450 core
uniform sampler2D source; // texelFetch(in a comment
#define READ(place) texelFetch(source, place, 0)
out vec4 colour;
float depends() {
    return gl_FragCoord.x < 3.0 ? READ(ivec2(texelFetch(source, ivec2(0), 0).xy)).x : 0.0;
}
void main() {
    if (gl_FragCoord.y < 1.0) {
        colour = READ(ivec2(0));
        discard;
    }
    colour = vec4(depends()) + float(textureSize(source, 0).x);
}
"""


def test_reads_within_reads_in_macros_in_branches_and_before_a_discard_count(ctx):
    program = ctx.program(VERTEX, with_counted_reads(NESTED, lambda _: ""))
    source, target = (gl.color_texture(ctx, (8, 4)) for _ in range(2))
    array = ctx.vertex_array(program, [])
    declared = Pass("nested", (PassImage.of(source),), (PassImage.of(target),))
    source.use(0)
    with ctx.scope(ctx.framebuffer([target])):
        draw = lambda: array.render(moderngl.TRIANGLES, vertices=3)  # noqa: E731
        (drawn,) = counted(ctx, lambda: declared.run(draw))
    assert drawn.samples == 8 * 3  # one row is discarded
    assert drawn.reads == 8 * 1 + 3 * 3 * 2


def test_a_shader_without_reads_stays_as_it_is():
    assert with_counted_reads(VERTEX, lambda _: "") == VERTEX
