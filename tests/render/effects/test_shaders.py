"""Every shader has a bound in the docs, and every formula that shaders share a test."""

import re

from tests.support.places import ROOT
from vrcomfort.resources import data_folder


def test_every_shader_has_its_bound_in_the_docs():
    root = ROOT
    text = (root / "docs" / "extremes.md").read_text(encoding="utf-8")
    files = data_folder("shaders").rglob("*.*")
    assert [
        file.name
        for file in files
        if file.parent.name != "include" and f"`{file.name}`" not in text
    ] == []


THROUGH = {
    "eye_of_vertex": "passes on tiles of both eyes (render/test_both_eyes.py)",
    "clip_now": "the scene's images",
    "through_lens": "the reference's images (render/test_depth_and_lens.py)",
    "zone_depth": "focus_weights.frag and focus_candidates.frag (render/focus/test_zone.py)",
    "refocused": "focus.frag, with every law (render/focus/test_pass.py)",
    "unlimited_radius_at": "colour_and_coc.frag (render/effects/test_lens_laws.py)",
    "widest_px": "the shaders that look around (render/effects/test_levels.py)",
    "distance_times_depth": "colour_and_coc.frag (render/focus/test_along_ray.py)",
    "reaches": "the same",
    "matters": "the same",
    "tiles_around": "the same",
    "radius_at": "colour_and_coc.frag and coc_tile_min_max.frag (render/effects/test_lens_laws.py)",
    "near_part": "near_layer.frag (render/effects/test_near_things.py)",
    "apart": "near_gather.frag (the same)",
    "near_over": "near_over.frag and complex.frag (render/effects/test_far_lamps.py)",
    "finite": "resolve.frag and colour_and_coc.frag (render/effects/test_resolve.py)",
    "velocity_at": "the shaders of motion blur (render/effects/test_extremes_fuzz.py)",
    "half_velocity_at": "the same (render/effects/test_motion_blur.py: the limit, the shutter)",
    "read_across": "the same (as the twin says)",
    "axis_across": "the same, where reads are cubic (more samples are closer)",
    "mean_of_reads": "the same (a cubic read makes nothing brighter or darker)",
    "add_peripheral_px": "colour_and_coc.frag (render/effects/test_peripheral.py)",
    "mean_over": "fast.frag and gather.frag (render/effects/test_depth_of_field.py)",
    "mean_of_taps": "half_fast.frag and half_mixed.frag (render/effects/test_half_gather.py)",
    "gathered_part": "the same",
    "gap_px": "coc_tile_dilate.frag (render/effects/test_depth_of_field.py)",
    "levels_of": "coc_tile_min_max.frag (render/effects/test_levels.py)",
    "on_image": "scene.frag and depth.frag (scene/test_extensions.py)",
    "bent": "scene.vert and depth.vert (scene/test_skins.py)",
    "pbr_neutral": "tone_map.frag (render/test_tone.py)",
    "srgb_encoded": "tone_map.frag (render/test_tone.py)",
}
"""Shared functions that only whole shaders call, and where these meet their NumPy twin."""

FUNCTION = re.compile(r"^(?:float|vec\d|mat\d|int|bool) (\w+)\(", re.MULTILINE)
CALL = re.compile(r"(?<![\w.])(\w+)\(")


def test_every_shared_formula_has_a_test():
    """Each function of shaders/include is called in a test, or by one that is.

    A NumPy twin's name comes after a dot.
    """
    bodies = dict(shared_functions())
    texts = (file.read_text(encoding="utf-8") for file in (ROOT / "tests").rglob("test_*.py"))
    tried = bodies.keys() & {name for text in texts for name in CALL.findall(text)}
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
