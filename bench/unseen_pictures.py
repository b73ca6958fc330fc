"""Pictures of an unseen scene: without blur, through the lens, and with steps of depth of field.

``python -m bench.unseen_pictures SEED X Y OUT.png``: 256 pixels of the window of ``--only unseen``
around the place (x to the right, y down) at 100 %, and below them 64 pixels at 400 %.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from bench.unseen import case, drawn_with, through_the_lens
from vrcomfort.geometry import Array
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.tradeoff.methods import methods

WHOLE_PX, DETAIL_PX, TIMES, GAP_PX = 256, 64, 4, 4
VIEWS = 512
SHOWN = ("no blur", "ours 12 samples", "ours 16 samples", "ours 36 samples", "ours 96 samples")


def draw(seed: int, place: tuple[int, int], out: Path) -> None:
    """Write the pictures side by side: no blur, `VIEWS` views, then our steps."""
    tried = {each.name: each for each in methods("depth_of_field")}
    with tempfile.TemporaryDirectory() as folder:
        found = case(seed, Path(folder))
        judged = found.window.within(found.drawn)
        images = [drawn_with(found, tried[name]).blurred[judged] for name in SHOWN]
        images.insert(1, through_the_lens(found, VIEWS))
    side = DETAIL_PX * TIMES
    sheet = Image.new("RGB", ((side + GAP_PX) * len(images) - GAP_PX, 2 * side + GAP_PX), "white")
    for column, image in enumerate(images):
        shown = _eight_bits(image, found.scene.environment.exposure)
        left = column * (side + GAP_PX)
        sheet.paste(Image.fromarray(_around(shown, place, WHOLE_PX)), (left, 0))
        detail = Image.fromarray(_around(shown, place, DETAIL_PX))
        sheet.paste(detail.resize((side, side), Image.Resampling.NEAREST), (left, side + GAP_PX))
    sheet.save(out, optimize=True)


def _eight_bits(linear: Array, exposure: float) -> Array:
    shown = tone_mapped(np.asarray(linear, dtype=np.float64), exposure=exposure)
    return np.asarray(np.round(shown * 255), dtype=np.uint8)[::-1]


def _around(image: Array, place: tuple[int, int], size_px: int) -> Array:
    height, width, _ = image.shape
    left, top = (
        min(max(middle - size_px // 2, 0), limit - size_px)
        for middle, limit in zip(place, (width, height), strict=True)
    )
    return np.ascontiguousarray(image[top : top + size_px, left : left + size_px])


if __name__ == "__main__":
    seed, x, y = map(int, sys.argv[1:4])
    draw(seed, (x, y), Path(sys.argv[4]))
