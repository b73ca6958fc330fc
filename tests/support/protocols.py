"""Builds small protocols for tests: two conditions, and the tables that a test is about."""

from __future__ import annotations

from collections.abc import Sequence

from vrcomfort.protocol import Protocol, parse_protocol

PLAIN = '[[conditions]]\nname = "plain"\n'
BLUR = '[[conditions]]\nname = "blur"\n[conditions.depth_of_field]\n'
LATIN_SQUARE = '[order]\nrule = "latin_square"\n'
ASKED_BEFORE = '[[questionnaires]]\ntimepoint = "baseline"\nwhen = "session_start"\n'
ASKED_AFTER_EACH = '[[questionnaires]]\ntimepoint = "post"\nwhen = "after_trial"\n'
NOBODY_LEAVES = "[simulation]\nhazard_per_min = 0.0\nquestion_hazard = 0.0\n"


def protocol_text(
    *tables: str,
    name: str = "tiny",
    exposure_s: float = 1.0,
    scene: str = "room.glb",
    keys: str = "",
    conditions: Sequence[str] = (PLAIN, BLUR),
    order: str = LATIN_SQUARE,
) -> str:
    """Return a protocol's TOML: `keys` stand above all tables, `tables` below the order."""
    head = f'name = "{name}"\ntitle = "A tiny study"\nexposure_s = {exposure_s}\n'
    scenes = f'scenes = ["{scene}"]\n{keys}'
    return "\n".join([head + scenes, *conditions, order, *tables])


def explicit_order(scene: str = "room.glb", /, **sequences: Sequence[Sequence[str]]) -> str:
    """Return an order table: name of a sequence → the conditions of each of its sessions."""
    text = '[order]\nrule = "explicit"\n'
    for name, sessions in sequences.items():
        rows = [
            ", ".join(f'{{ scene = "{scene}", condition = "{each}" }}' for each in session)
            for session in sessions
        ]
        listed = "".join(f"  [{row}],\n" for row in rows)
        text += f'[[order.sequences]]\nname = "{name}"\nsessions = [\n{listed}]\n'
    return text


def generated(rule: str, conditions: int, extra: str = "", tables: str = "") -> Protocol:
    """Return a protocol with one scene and a generated order."""
    named = [f'[[conditions]]\nname = "c{n}"\n' for n in range(conditions)]
    order = f'[order]\nrule = "{rule}"\n{extra}{tables}'
    text = protocol_text(ASKED_AFTER_EACH, scene="room.gltf", conditions=named, order=order)
    return parse_protocol(text)


GROUPS = """
[[groups]]
name = "near"
conditions = ["c0", "c1"]
[[groups]]
name = "far"
conditions = ["c2", "c3"]
"""
COVARIATES = """
[[covariates]]
name = "sex"
levels = ["female", "male"]
[[covariates]]
name = "age"
low = 18
high = 70
cuts = [30, 50]
[[covariates]]
name = "susceptibility"
levels = ["low", "middle", "high"]
"""


def grouped(allocation: str, *, rule: str = "williams", extra: str = "") -> Protocol:
    """Return a protocol with two groups, three covariates and an [allocation] table."""
    tables = f"{GROUPS}{COVARIATES}[allocation]\n{allocation}\n"
    return generated(rule, 4, extra, tables)
