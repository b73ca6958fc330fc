"""Protocols for tests of orders and groups, without scenes of their own."""

from __future__ import annotations

from tests.support.study import PROTOCOL
from vrcomfort.protocol import Protocol, parse_protocol


def generated(rule: str, conditions: int, extra: str = "", tables: str = "") -> Protocol:
    """Return a protocol with one scene and a generated order."""
    head = PROTOCOL.split("[[conditions]]")[0].replace(".glb", ".gltf")
    tail = PROTOCOL[PROTOCOL.index("[[questionnaires]]") :]
    named = "".join(f'[[conditions]]\nname = "c{n}"\n' for n in range(conditions))
    return parse_protocol(f'{head}{named}[order]\nrule = "{rule}"\n{extra}{tables}{tail}')


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
