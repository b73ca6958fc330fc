"""Fitted constants of shaders: the error with each, and with less and more in its place.

A constant is fitted by this benchmark where its line in a shader says ``// Fitted: python -m bench
--only fitted``. Errors are those of ``vrcomfort tradeoff``: at places on the shipped walks, against
references of many views through the lens.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from bench.clocked import replaced
from bench.table import Result
from vrcomfort.gpu import shaders
from vrcomfort.protocol.conditions import Condition, DepthOfField
from vrcomfort.resources import data_folder
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.measure import images_of, view_of
from vrcomfort.tradeoff.methods import FOCUS, LENSES, BlurMethod, LensName
from vrcomfort.tradeoff.store import Store, default_folder, scene_and_hash

COMMAND = "python -m bench --only fitted"
LINE = re.compile(rf"const float (\w+) = ([\d.]+);(\s*)// Fitted: {re.escape(COMMAND)}$", re.M)
FACTORS = (0.5, 2.0)
SIZE_PX, SAMPLES = (160, 200), 128
LENS: LensName = "7"
SCENES = ("temple", "mountain")


class Fitted(NamedTuple):
    """A constant in a shader."""

    file: str
    name: str
    value: float


def constants() -> list[Fitted]:
    """Return all that name this benchmark, by file."""
    folder = data_folder("shaders")
    return [
        Fitted(file.relative_to(folder).as_posix(), found[1], float(found[2]))
        for file in sorted(folder.rglob("*.*"))
        for found in LINE.finditer(file.read_text(encoding="utf-8"))
    ]


def measure(*, scene: str | None = None) -> Result:
    """Draw the same views with each constant times each factor."""
    scenes = (scene,) if scene else SCENES
    found = constants()
    own = [_error(name) for name in scenes]
    rows = []
    for constant in found:
        row: dict[str, object] = {"constant": f"{constant.name} = {constant.value:g}"}
        for factor in FACTORS:
            with changed(constant, factor):
                errors = [_error(name) for name in scenes]
            shares = (a / b for a, b in zip(errors, own, strict=True))
            row[f"× {factor:g}"] = " / ".join(f"{share:.3f}" for share in shares)
        rows.append(row)
    notes = [
        f"RMS errors over those with the constant itself: {' / '.join(scenes)}; "
        f"{SIZE_PX[0]}×{SIZE_PX[1]} px, references of {SAMPLES} views, the second place on each "
        f"walk, discs of up to {LENS} % of the width."
    ]
    return Result("Fitted constants of shaders", rows, notes)


def _error(scene: str) -> float:
    """Return the RMS error of our kernel in a scene."""
    case = Case(scene, 1, "still", "depth_of_field", LENS)
    scope = Scope(size_px=SIZE_PX, samples=SAMPLES, eyes=1)
    lens = DepthOfField(**LENSES[LENS])
    condition = Condition(name="fitted", focus=FOCUS, depth_of_field=lens)
    method = BlurMethod("fitted", "depth_of_field", "ours", condition)
    (eye,) = view_of(case, scope, STORE)
    (image,) = images_of(case, scope, method, scene_and_hash(scene)[0])
    return float(np.sqrt(np.mean(eye.error(image) ** 2)))


STORE = Store(default_folder())


@contextmanager
def changed(constant: Fitted, factor: float) -> Iterator[None]:
    """Compile programs inside with a constant times a factor."""
    plain = shaders.source
    line = re.compile(rf"(const float {constant.name} = )[\d.]+;")

    def source(name: str) -> str:
        text = plain(name)
        if name != constant.file:
            return text
        return line.sub(rf"\g<1>{factor * constant.value:.9f};", text)

    with replaced(shaders, "source", source):
        yield
