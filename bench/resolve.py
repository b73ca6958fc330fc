"""Edges of lamps by the way in which the samples of a pixel become its colour.

``python -m bench --only resolve`` draws a lamp that is turned by 7° over a dark wall, at 16 places
of a head that moves by an eighth of a pixel, with both ways. It compares display light with that of
an image eight times as fine: tones are mapped first, and means taken then.

edges           RMS error·10³ at the lamp's edges
flicker         RMS change·10³ of that error from one place to the next
light kept      light of all pixels, before tone mapping, of the fine image's
of a small one  the same of a lamp one and a half pixels wide: what its blurred disc has left
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from bench.table import Result
from scenes.kit.glb import GlbWriter
from scenes.kit.shapes import box
from vrcomfort.geometry import Array, Fov, Pose
from vrcomfort.optics.tone import pbr_neutral
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Resolve, Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.brute_force import read_rgb

SIDE_PX, FINER = 96, 8
LAMP_M = 4.0
WIDE_RAD = np.radians(12.0)
PLACES = 16
RESOLVES: tuple[Resolve, ...] = ("mean", "by_brightness")
RADIANCES = (2.0, 10.0, 50.0)
"""Of the lamp, in units of display white."""
SIDE_CAR = """resolve = "{resolve}"
[sun]
irradiance = [0, 0, 0]
[sky]
zenith = [0, 0, 0]
horizon = [0, 0, 0]
ground = [0, 0, 0]
"""


def pixel_m() -> float:
    """Return how wide a pixel is where the lamp is."""
    return float(2 * LAMP_M * np.tan(WIDE_RAD / 2) / SIDE_PX)


def lamp(folder: Path, radiance: float, wall: float, size_px: float, resolve: Resolve) -> Scene:
    """Return a scene of a square lamp, so many pixels wide, before a wall that shines too."""
    writer = GlbWriter()
    side = size_px * pixel_m()
    shapes = {
        "lamp": (
            box([side, side, 0.001]).at(0, -side / 2).turned("z", 7).at(0, 0, -LAMP_M),
            radiance,
        ),
        "wall": (box([9, 9, 0.1]).at(0, -4.5, -LAMP_M - 1), wall),
    }
    for name, (mesh, light) in shapes.items():
        material = writer.material(name, color=(0, 0, 0), emissive=np.full(3, light))
        writer.node(name, writer.mesh(name, [(mesh, material)]))
    path = folder / "lamp.glb"
    writer.save(path)
    path.with_suffix(".toml").write_text(SIDE_CAR.format(resolve=resolve), encoding="utf-8")
    return load_scene(path)


def draw(ctx: moderngl.Context, scene: Scene, finer: int, places: int) -> Array:
    """Return (places, h, w, 3) radiance, seen from places an eighth of a pixel apart."""
    size_px = (finer * SIDE_PX, finer * SIDE_PX)
    drawing = ScenePass(ctx, scene, size_px, velocity=False)
    seen = []
    for place in range(places):
        head = Pose((place * pixel_m() / 8, 0.0, 0.0))
        fov = Fov.symmetric(vertical_rad=WIDE_RAD, aspect=1.0)
        drawing.render(EyeCamera(head, fov, world_from_head=head), 0.0)
        seen.append(read_rgb(drawing.colour))
    return np.array(seen, dtype=np.float64)


def measure(ctx: moderngl.Context) -> Result:
    """Compare both ways for lamps of several radiances."""
    with tempfile.TemporaryDirectory() as folder:
        rows = [_row(ctx, Path(folder), light, each) for light in RADIANCES for each in RESOLVES]
    notes = [
        f"{SIDE_PX}×{SIDE_PX} px of 12°, 4 samples a pixel, {PLACES} places; the wall has 0.05. "
        "Light of displays is linear, 1 is white. Both ways read and write the same bytes.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Edges of lamps", rows, notes)


def _row(ctx: moderngl.Context, folder: Path, radiance: float, resolve: Resolve) -> dict[str, Any]:
    seen = draw(ctx, lamp(folder, radiance, 0.05, 40.0, resolve), 1, PLACES)
    true = draw(ctx, lamp(folder, radiance, 0.05, 40.0, "mean"), FINER, PLACES)
    shown, ideal = pbr_neutral(seen), _means(pbr_neutral(true))
    around = (1, 3, 3, 1)
    edges = maximum_filter(ideal, around) - minimum_filter(ideal, around) > 0.01
    error = np.where(edges, shown - ideal, 0.0)
    change = np.diff(error, axis=0)[(edges[1:] & edges[:-1])]
    small, small_true = (
        draw(ctx, lamp(folder, radiance, 0.0, 1.5, each), finer, PLACES)
        for each, finer in ((resolve, 1), ("mean", FINER))
    )
    return {
        "lamp": radiance,
        "resolve": resolve,
        "edges": float(np.sqrt(np.mean(error[edges] ** 2)) * 1e3),
        "flicker": float(np.sqrt(np.mean(change**2)) * 1e3),
        "light kept": float(seen.sum() / _means(true).sum()),
        "of a small one": float(small.sum() / _means(small_true).sum()),
    }


def _means(fine: Array) -> Array:
    """Return (n, h, w, 3) means over the pixels of images that are `FINER` times as fine."""
    places, height, width, channels = fine.shape
    blocks = fine.reshape(places, height // FINER, FINER, width // FINER, FINER, channels)
    means: Array = blocks.mean(axis=(2, 4))
    return means
