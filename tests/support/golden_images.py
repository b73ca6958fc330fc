"""Compares pictures with golden ones: only on llvmpipe, whose arithmetic is the same everywhere.

``pytest --update-golden`` writes them. On failure the picture and the difference, ten times
amplified, are left in the test's temporary folder.
"""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from PIL import Image

from tests.support.places import ROOT

FOLDER = ROOT / "tests/golden"
DRIVER = FOLDER / "driver.txt"
VERSIONS = FOLDER / "stimulus_versions.txt"

TOLERANCE = 1
"""Largest difference of a channel, of 255."""

EDGE_FRACTION = 0.001
"""Share of pixels that may differ more: an edge on a sample's rim falls to either side where
vector widths round differently."""

OTHER_MESA_TOLERANCE, OTHER_MESA_FRACTION = 4, 0.02
"""With another Mesa than the one in ``golden/driver.txt``: guarded loosely, not measured."""


def compare(request, ctx, tmp_path, name: str, image: np.ndarray) -> None:
    """Assert that an (height, width, 3) uint8 image is the golden one called `name`."""
    renderer, version = ctx.info["GL_RENDERER"], ctx.info["GL_VERSION"]
    if "llvmpipe" not in renderer:
        pytest.skip(f"golden images are for llvmpipe, this is {renderer}")
    path = FOLDER / f"{name}.png"
    if request.config.getoption("--update-golden"):
        FOLDER.mkdir(exist_ok=True)
        Image.fromarray(image).save(path)
        DRIVER.write_text(f"{version}\n", encoding="utf-8")
        return
    same_mesa = DRIVER.read_text(encoding="utf-8").strip() == version
    difference = np.abs(image.astype(int) - np.asarray(Image.open(path)).astype(int))
    tolerance = TOLERANCE if same_mesa else OTHER_MESA_TOLERANCE
    allowed = EDGE_FRACTION if same_mesa else OTHER_MESA_FRACTION
    worse = (difference.max(axis=-1) > tolerance).mean()
    if worse > allowed:
        Image.fromarray(image).save(tmp_path / f"{name}.png")
        amplified = np.minimum(difference * 10, 255).astype(np.uint8)
        Image.fromarray(amplified).save(tmp_path / f"{name}_difference.png")
        pytest.fail(
            f"{worse:.2%} of the pixels of {name} differ by more than {tolerance}/255 "
            f"(largest {difference.max()}); see {tmp_path}"
        )


def pixels_sha256() -> dict[str, str]:
    """Return the checksum of the pixels of each golden picture."""
    images = {path.name: Image.open(path) for path in sorted(FOLDER.glob("*.png"))}
    return {
        name: hashlib.sha256(f"{each.size} {each.mode}".encode() + each.tobytes()).hexdigest()
        for name, each in images.items()
    }
