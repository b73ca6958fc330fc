"""The patch for a photodiode: where it is, when it is white, and that it is in the images."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.render.test_pipeline import PLAIN, SIZE, standing, still_life
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov
from vrcomfort.protocol.viewing import Photodiode
from vrcomfort.render.display import PatchLight, patch_place
from vrcomfort.render.output import read_rgb8
from vrcomfort.render.pipeline import StereoRenderer

FOV = Fov(-math.pi / 4, math.pi / 4, math.pi / 4, -math.pi / 4)
"""Tangents from −1 to 1: 100 px are 0.02 each."""


@pytest.mark.parametrize(
    ("corner", "left", "bottom"),
    [
        ("lower_left", True, True),
        ("lower_right", False, True),
        ("upper_left", True, False),
        ("upper_right", False, False),
    ],
)
def test_it_is_so_many_degrees_from_its_corner(corner: str, left: bool, bottom: bool) -> None:
    settings = Photodiode(corner=corner, size_deg=10.0, inset_deg=5.0)
    first = (1 - math.tan(math.radians(40))) / 0.02  # px from the edge
    last = (1 - math.tan(math.radians(30))) / 0.02
    x, y, width, height = patch_place(settings, FOV, (100, 100))
    low, high = round(first), round(last)
    assert (x, x + width) == ((low, high) if left else (100 - high, 100 - low))
    assert (y, y + height) == ((low, high) if bottom else (100 - high, 100 - low))


def test_it_never_leaves_the_image_nor_vanishes() -> None:
    for settings in (Photodiode(size_deg=45, inset_deg=60), Photodiode(size_deg=0.5)):
        x, y, width, height = patch_place(settings, FOV, (16, 16))
        assert min(width, height) >= 1
        assert max(x + width, y + height) <= 16


def test_at_an_onset_it_is_white_for_its_time_and_else_in_every_other_frame() -> None:
    times_ns = [1_000_000_000 + 11_000_000 * frame for frame in range(6)]
    onset = PatchLight(Photodiode(onset_s=0.03))
    assert [onset.of_next(time_ns) for time_ns in times_ns] == [True] * 3 + [False] * 3
    other = PatchLight(Photodiode(white="every_other_frame"))
    assert [other.of_next(time_ns) for time_ns in times_ns] == [True, False] * 3


def test_it_is_black_or_white_in_both_eyes_and_the_rest_is_as_without(ctx) -> None:
    settings = Photodiode(size_deg=10.0)
    at = standing(0)
    time_ns, period_ns = at.predicted_display_time_ns, at.period_ns
    frame = Frame(0, time_ns, period_ns, at.head_pose, at.views, at.avatar_pose, True, True)
    images = {}
    for patch in (None, False, True):
        renderer = StereoRenderer(ctx, SIZE, photodiode=settings)
        renderer.begin(still_life(), PLAIN)
        eyes = renderer.render(replace(frame, patch=patch), 0.0).eyes
        images[patch] = [read_rgb8(eye) for eye in eyes]
        renderer.release()
    for eye, view in enumerate(frame.views):
        left, bottom, width, height = patch_place(settings, view.fov, SIZE)
        rows = slice(SIZE[1] - bottom - height, SIZE[1] - bottom)
        columns = slice(left, left + width)
        for patch, value in ((False, 0), (True, 255)):
            assert (images[patch][eye][rows, columns] == value).all()
            rest = images[patch][eye].copy()
            rest[rows, columns] = images[None][eye][rows, columns]
            np.testing.assert_array_equal(rest, images[None][eye])
