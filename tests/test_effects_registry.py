"""One list of effects: what stands in it is a setting of conditions and of levels of factors."""

from __future__ import annotations

import json
import subprocess
import sys

from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.protocol.conditions import EFFECTS
from vrcomfort.render import graph

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
