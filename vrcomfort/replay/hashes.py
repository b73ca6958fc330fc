"""Whether the images of a replay are those that the participant saw."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from vrcomfort.records import Machine


@dataclass
class Comparison:
    """How many of the recorded hashes the replay's images have.

    Attributes
    ----------
    compared, equal
        Frames of which a hash is recorded and that were drawn again; those whose both images are
        equal to the last bit.
    """

    compared: int = 0
    equal: int = 0

    def add(self, recorded: tuple[str, str], now: tuple[str, str]) -> bool:
        """Compare one frame; return whether it is equal."""
        same = recorded == now
        self.compared += 1
        self.equal += same
        return same

    @property
    def sentence(self) -> str:
        """Say it."""
        if not self.compared:
            return "no recorded image was among those drawn; whether they are equal is not known"
        return f"{self.equal} of {self.compared} recorded images are equal to the last bit"


def differences(manifest: Mapping[str, Any], machine: Machine) -> Iterator[str]:
    """Yield changes since the session was run that may change images."""
    for name in ("gpu", "driver"):
        then, now = manifest.get(name) or "", getattr(machine, name)
        if then and then != now:
            yield f"the {name} was {then}, and is {now}"
    then = manifest.get("shaders") or {}
    changed = sorted(name for name in then if machine.shaders.get(name) != then[name])
    if changed:
        first = ", ".join(changed[:3]) + (", …" if len(changed) > 3 else "")
        yield f"{len(changed)} of {len(then)} shaders have changed ({first})"
