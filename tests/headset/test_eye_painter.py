"""What a window shows: images as they are, panels where they stand."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from vrcomfort.geometry import Fov, Pose, Quad, View
from vrcomfort.headset.eye_painter import EyePainter, WindowPanel, fitted

SIZE = 64
RIGHT_ANGLE = View(Pose(), Fov.symmetric(vertical_rad=np.pi / 2, aspect=1.0))
RED, BLUE = (255, 0, 0, 255), (0, 0, 255, 255)


def panel(ctx: moderngl.Context, quad: Quad, color: tuple[int, ...]) -> WindowPanel:
    made = WindowPanel(ctx, (8, 8), quad)
    made.draw(np.full((8, 8, 4), color, np.uint8))
    return made


def painted(
    ctx: moderngl.Context,
    image: moderngl.Texture | None,
    panels: list[WindowPanel],
    box: tuple[int, int, int, int] = (0, 0, SIZE, SIZE),
) -> np.ndarray:
    target = ctx.framebuffer([ctx.texture((SIZE, SIZE), 4)])
    target.clear()
    EyePainter(ctx).paint(target, box, image, RIGHT_ANGLE, panels)
    pixels = np.frombuffer(target.read(components=4), np.uint8)
    return pixels.reshape(SIZE, SIZE, 4)[::-1]


def test_an_image_of_the_box_s_size_is_copied(ctx: moderngl.Context) -> None:
    noise = np.random.default_rng(2).integers(0, 256, (SIZE, SIZE, 4), np.uint8)
    shown = painted(ctx, ctx.texture((SIZE, SIZE), 4, noise[::-1].tobytes()), [])
    assert np.array_equal(shown, noise)


@pytest.mark.smoke
def test_an_image_is_scaled_into_its_box(ctx: moderngl.Context) -> None:
    shown = painted(ctx, ctx.texture((4, 4), 4, bytes(RED * 16)), [], (16, 0, 32, 48))
    lit = np.argwhere(shown[..., 0] > 0)
    assert lit.min(axis=0).tolist() == [16, 16]
    assert lit.max(axis=0).tolist() == [63, 47]
    assert (shown[16:, 16:48] == RED).all()


def test_a_scaled_image_is_smooth_whatever_its_own_filter(ctx: moderngl.Context) -> None:
    image = ctx.texture((2, 1), 4, bytes(RED + BLUE))
    image.filter = moderngl.NEAREST, moderngl.NEAREST
    red, blue = painted(ctx, image, [])[SIZE // 2, :, (0, 2)].astype(int)
    assert np.ptp(red) == np.ptp(blue) == 255
    assert (np.diff(red) <= 0).all()
    assert np.abs(np.diff(red)).max() < 16


def test_a_panel_stands_where_its_quad_says(ctx: moderngl.Context) -> None:
    # At 2 m and 90 degrees the image is 4 m wide: 16 pixels a metre.
    quad = Quad(Pose(np.array([0.5, 1.0, -2.0])), (1.0, 0.5))
    shown = painted(ctx, None, [panel(ctx, quad, RED)])
    lit = np.argwhere(shown[..., 0] > 0)
    assert lit.min(axis=0).tolist() == [32 - 16 - 4, 32]
    assert lit.max(axis=0).tolist() == [32 - 16 + 3, 32 + 15]


def test_a_panel_covers_the_image_as_much_as_it_is_opaque(ctx: moderngl.Context) -> None:
    image = ctx.texture((SIZE, SIZE), 4, bytes(BLUE * SIZE * SIZE))
    whole = Quad(Pose(np.array([0.0, 0.0, -1.0])), (2.0, 2.0))
    ctx.blend_func = moderngl.ONE, moderngl.ONE  # as passes that add up leave it
    shown = painted(ctx, image, [panel(ctx, whole, (255, 0, 0, 51))])
    assert shown[32, 32, :3] == pytest.approx([51, 0, 204], abs=1)


def test_a_hidden_panel_says_so(ctx: moderngl.Context) -> None:
    gone: list[WindowPanel] = []
    made = WindowPanel(ctx, (4, 4), Quad(Pose(), (1.0, 1.0)), gone.append)
    made.hide()
    assert gone == [made]


@pytest.mark.parametrize(
    ("size", "aspect", "column", "of", "box"),
    [
        ((200, 100), 1.0, 0, 2, (0, 0, 100, 100)),
        ((200, 100), 1.0, 1, 2, (100, 0, 100, 100)),
        ((200, 100), 0.5, 0, 1, (75, 0, 50, 100)),
        ((100, 100), 2.0, 0, 1, (0, 25, 100, 50)),
    ],
)
def test_images_keep_their_proportions(
    size: tuple[int, int], aspect: float, column: int, of: int, box: tuple[int, ...]
) -> None:
    assert fitted(size, aspect, column=column, of=of) == box
