"""Hashes of shown images: the GPU's are the twin's, and any change of a pixel changes them."""

from __future__ import annotations

import numpy as np
import pytest

from vrcomfort.frame import ImageHash
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.render.display import ImageHasher, image_hash
from vrcomfort.render.output import read_rgb8


def picture(size_px, seed):
    width, height = size_px
    return np.random.default_rng(seed).integers(0, 256, (height, width, 4), dtype=np.uint8)


@pytest.mark.parametrize("size_px", [(1, 1), (7, 3), (130, 5), (128, 2)])
@pytest.mark.smoke
def test_the_hash_of_a_texture_is_that_of_its_picture_in_a_file(ctx, size_px):
    textures = tuple(ctx.texture(size_px, 4, picture(size_px, seed).tobytes()) for seed in (1, 2))
    hasher = ImageHasher(ctx)

    hasher.take(5, textures)

    assert hasher.drain() == (ImageHash(5, *(image_hash(read_rgb8(each)) for each in textures)),)


def test_hashes_arrive_as_many_frames_late_as_focus_does(ctx):
    texture = ctx.texture((8, 8), 4, picture((8, 8), 3).tobytes())
    hasher = ImageHasher(ctx)
    arrived = []
    for index in range(3 * LATENCY):
        if index % 2 == 0:
            hasher.take(index, (texture, texture))
        arrived.append([each.frame_index for each in hasher.arrived()])

    assert arrived[:LATENCY] == [[]] * LATENCY
    assert [index for each in arrived for index in each] == list(range(0, 2 * LATENCY, 2))
    assert [each.frame_index for each in hasher.drain()] == list(range(2 * LATENCY, 3 * LATENCY, 2))


def test_one_step_of_one_channel_and_two_pixels_that_change_places_are_seen():
    image = picture((40, 30), 4)[..., :3]
    known = image_hash(image)
    for channel in range(3):
        changed = image.copy()
        changed[11, 7, channel] ^= 1
        assert image_hash(changed) != known
    swapped = image.copy()
    swapped[0, 0], swapped[29, 39] = image[29, 39], image[0, 0]
    assert image_hash(swapped) != known
    assert image_hash(image[::-1]) != known
    assert len(known) == 16
    assert int(known, 16) >= 0
