"""Every shader has a bound in the docs, and every formula that shaders share a test."""

import re
from pathlib import Path

import pytest

from vrcomfort.resources import data_folder


def test_every_shader_has_its_bound_in_the_docs():
    root = Path(__file__).resolve().parent.parent
    text = (root / "docs" / "extremes.md").read_text(encoding="utf-8")
    files = data_folder("shaders").rglob("*.*")
    assert [
        file.name
        for file in files
        if file.parent.name != "include" and f"`{file.name}`" not in text
    ] == []


THROUGH = {
    "clip_now": "the scene's images",
    "through_lens": "the reference's images (test_render_depth_and_lens.py)",
    "zone_depth": "focus_weights.frag and focus_candidates.frag (test_focus_zone.py)",
    "refocused": "focus.frag, with every law (test_focus_pass.py)",
    "unlimited_radius_at": "colour_and_coc.frag (test_effects_lens_laws.py)",
    "widest_px": "the shaders that look around (test_effects_levels.py)",
    "distance_times_depth": "colour_and_coc.frag (test_focus_along_ray.py)",
    "reaches": "the same",
    "matters": "the same",
    "tiles_around": "the same",
    "radius_at": "colour_and_coc.frag and coc_tile_min_max.frag (test_effects_lens_laws.py)",
    "finite": "resolve.frag and colour_and_coc.frag (test_effects_resolve.py)",
    "velocity_at": "the shaders of motion blur (test_effects_motion_blur.py: extremes)",
    "half_velocity_at": "the same (test_effects_motion_blur.py: the limit, the shutter)",
    "read_across": "the shaders of motion blur (test_effects_motion_blur.py: as the twin says)",
    "axis_across": "the same, where reads are cubic (more samples are closer)",
    "mean_of_reads": "the same (a cubic read makes nothing brighter or darker)",
    "add_peripheral_px": "colour_and_coc.frag (test_effects_peripheral.py)",
    "mean_over": "fast.frag and gather.frag (test_effects_depth_of_field.py)",
    "gap_px": "coc_tile_dilate.frag (test_effects_depth_of_field.py)",
    "levels_of": "coc_tile_min_max.frag (test_effects_levels.py)",
    "on_image": "scene.frag and depth.frag (test_scenes_extensions.py)",
    "bent": "scene.vert and depth.vert (test_scenes_skins.py)",
    "pbr_neutral": "tone_map.frag (test_render_tone.py)",
    "srgb_encoded": "tone_map.frag (test_render_tone.py)",
}
"""Shared functions that only whole shaders call, and where these meet their NumPy twin."""

FUNCTION = re.compile(r"^(?:float|vec\d|mat\d|int|bool) (\w+)\(", re.MULTILINE)


@pytest.mark.slow
def test_every_shared_formula_has_a_test():
    """Each function of shaders/include is called in a test, or by one that is.

    A NumPy twin's name comes after a dot.
    """
    texts = [file.read_text(encoding="utf-8") for file in Path(__file__).parent.glob("test_*.py")]
    bodies = dict(shared_functions())
    called = {name: re.compile(rf"(?<![\w.]){name}\(") for name in bodies}
    tried = {name for name in bodies if any(called[name].search(text) for text in texts)}
    tried |= THROUGH.keys()
    for _ in bodies:
        tried |= {
            name for name in bodies for by in tried & bodies.keys() if f"{name}(" in bodies[by]
        }
    assert bodies.keys() - tried == set()


def shared_functions():
    """Yield (name, text) of each function of the include files."""
    for file in (data_folder("shaders") / "include").glob("*.glsl"):
        _, *parts = FUNCTION.split(file.read_text(encoding="utf-8"))
        yield from zip(parts[::2], parts[1::2], strict=True)
