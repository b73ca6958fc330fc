"""One list of effects: what stands in it is a setting of conditions and of levels of factors."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module

import pytest

from tests.support.places import ROOT
from tests.support.render import still_life
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.geometry import Pose
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.traffic import TrafficCounter
from vrcomfort.protocol.conditions import EFFECTS, Condition
from vrcomfort.protocol.quality_levels import dialled, quality_table
from vrcomfort.render import graph
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.settings.reading import fields_at
from vrcomfort.tradeoff.costs import a_step

FACTORS = """\
[[factors]]
name = "colour"
[[factors.levels]]
name = "white"
[[factors.levels]]
name = "red"
[factors.levels.tint]
strength = 0.25

[[factors]]
name = "first"
[[factors.levels]]
name = "usual"
[[factors.levels]]
name = "tinted_first"
effect_order = ["tint"]

"""

REGISTERED = '''
"""Registers an effect as docs/effects.md says, in the source that is imported, and crosses it."""

import importlib.machinery
import json
import sys
from pathlib import Path

TABLE = """class Tint(Settings):
    strength: float = 1.0


class EffectTables(Settings):"""
FIELD = """    vignette: Vignette | None = None
"""


class Registering(importlib.machinery.SourceFileLoader):
    def get_code(self, fullname):
        text = Path(self.path).read_text(encoding="utf-8")
        for place, changed in (
            ("class EffectTables(Settings):", TABLE),
            (FIELD, FIELD + "    tint: Tint | None = None\\n"),
        ):
            assert text.count(place) == 1
            text = text.replace(place, changed)
        return compile(text, self.path, "exec")


class Finder:
    def find_spec(self, name, path, target=None):
        if name != "vrcomfort.protocol.conditions":
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        spec.loader = Registering(name, spec.origin)
        return spec


sys.meta_path.insert(0, Finder())
from vrcomfort.protocol import load_protocol

conditions = load_protocol(sys.argv[1]).conditions
print(json.dumps([(c.name, {n: e.model_dump() for n, e in c.effects.items()}, c.effect_order)
                  for c in conditions]))
'''


GAZE = """\
[[factors]]
name = "centre"
[[factors.levels]]
name = "head"
[factors.levels.vignette]
[[factors.levels]]
name = "gaze"
[factors.levels.vignette]
[factors.levels.gaze_centre]
of = ["vignette"]

"""


def crossed(factors):
    """Return the small study with these factors in place of its conditions."""
    conditions = PROTOCOL[PROTOCOL.index("[[conditions]]") : PROTOCOL.index("[order]")]
    text = PROTOCOL.replace(conditions, factors)
    explicit = text[text.index('rule = "explicit"') : text.index("[[questionnaires]]")]
    return text.replace(explicit, 'rule = "williams"\n')


def test_an_effect_that_is_registered_once_can_be_crossed_as_a_factor(tmp_path):
    (tmp_path / "room.glb").touch()
    study = tmp_path / "study.toml"
    study.write_text(crossed(FACTORS), encoding="utf-8")
    script = tmp_path / "registers.py"
    script.write_text(REGISTERED, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script, study], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = {name: (effects, order) for name, effects, order in json.loads(done.stdout)}
    assert found == {
        "white_usual": ({}, [*EFFECTS, "tint"]),
        "white_tinted_first": ({}, ["tint", *EFFECTS]),
        "red_usual": ({"tint": {"strength": 0.25}}, [*EFFECTS, "tint"]),
        "red_tinted_first": ({"tint": {"strength": 0.25}}, ["tint", *EFFECTS]),
    }


def test_every_effect_has_a_way_to_be_drawn():
    assert tuple(graph.EFFECTS) == EFFECTS


def test_what_is_centred_on_the_gaze_can_be_crossed_as_a_factor(tmp_path):
    protocol = tiny_protocol(tmp_path, crossed(GAZE))
    assert [each.centred_on_gaze for each in protocol.conditions] == [(), ("vignette",)]


def test_levels_of_quality_name_effects_and_their_settings():
    assert set(dialled()) <= set(EFFECTS)
    for level in quality_table().levels.values():
        for effect, settings in level.root.items():
            fields = fields_at(Condition, ["depth_of_field" if effect == "lens" else effect])
            assert set(settings) <= set(fields), effect


def test_a_part_that_reads_what_no_part_writes_is_refused_by_name():
    plan = graph.EFFECTS["vignette"].plan
    scene = graph.FramePart("scene", plan, writes=("colour",))
    fog = graph.FramePart("fog", plan, reads=("colour", "haze"), writes=("colour",))
    haze = graph.FramePart("haze_search", plan, reads=("colour",), writes=("haze",))
    graph.check_parts([scene, haze, fog])
    with pytest.raises(ValueError, match="fog reads the image 'haze', which no part of a frame"):
        graph.check_parts([scene, fog])
    with pytest.raises(ValueError, match="'haze', which haze_search writes after it"):
        graph.check_parts([scene, fog, haze])


def test_the_figure_of_a_frame_is_made_from_its_declaration(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts")
    figure = import_module("frame_figure")
    parts = graph.frame_of(Condition(name="all"))
    drawn = figure.frame_svg(parts)
    assert figure.FILE.read_text(encoding="utf-8") == drawn, "run python scripts/frame_figure.py"
    assert drawn.count('fill="#1f5fa8"') == sum(len(part.writes) for part in parts)
    assert figure.frame_svg(parts[:-1]) != drawn


def test_an_effect_reads_the_images_that_it_declares(ctx):
    """Depth, focus and velocity are read by those that say so, and by no others."""
    walking = {"moving": {"from_m_s": 0.01, "to_m_s": 0.1}}
    of_this_step = {"motion_blur": {"mode": "full"}, "speed_blur": walking}
    settings = {name: effect.measured for name, effect in graph.EFFECTS.items()} | of_this_step
    condition = Condition.model_validate({"name": "all", **settings})
    renderer, counter = StereoRenderer(ctx, (48, 40), eyes=1), TrafficCounter(ctx)
    renderer.build(still_life(), condition)
    before, frame = a_step(Pose(), (48, 40))
    renderer.render(before, 0.0)
    with watched(counter):
        renderer.render(frame, 0.1)
    scene = renderer.scene_pass
    images = {
        "depth": scene.depth.glo, "velocity": scene.velocity.glo,
        "focus": renderer.focus.texture.glo,
    }  # fmt: skip
    for name, effect in graph.EFFECTS.items():
        read = {image.name for each in counter.parts[name] for image in each.declared.reads}
        if name == "depth_of_field":  # its radii are written where samples are resolved
            read |= {
                image.name for each in counter.parts["resolve"] for image in each.declared.reads
            }
        assert {image for image, number in images.items() if number in read} == effect.reads
    renderer.release()
