"""What a refocus law is to the rest: how far focus moves in a frame, and the shader that moves it.

A new law is its settings (`vrcomfort.protocol.conditions.Focus`), a file beside this one, its GLSL,
the GLSL's twin in ``tests/oracles/refocus.py``, and a place in the list of `laws`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

AT_ONCE = 3e38
"""A step of any law that reaches every target: what focus makes after a cut."""


@dataclass(frozen=True)
class RefocusLaw:
    """How focus follows its target.

    Parameters
    ----------
    name
        What `law` of a protocol calls it.
    step
        From the seconds since the frame before, and the settings by name, how far focus may move,
        in the unit that `glsl` takes.
    step_settings
        The settings that `step` takes.
    glsl
        File of ``shaders/include``: the function ``refocused(current, target)``, in metres, and its
        uniform `step_size`.
    uniforms
        The settings that `glsl` takes, as uniforms of their names.
    remembers
        Whether `glsl` keeps a second texel from frame to frame: `change`, and `change_before`.
    """

    name: str
    step: Callable[..., float]
    glsl: str
    step_settings: tuple[str, ...] = ()
    uniforms: tuple[str, ...] = ()
    remembers: bool = False

    @property
    def settings(self) -> frozenset[str]:
        """Return the settings that change what the law does."""
        return frozenset((*self.step_settings, *self.uniforms))

    def step_size(self, settings: Any, dt_s: float) -> float:
        """Return how far focus may move in `dt_s`."""
        return self.step(dt_s, **{name: getattr(settings, name) for name in self.step_settings})

    def constants(self, settings: Any) -> dict[str, float]:
        """Return the uniforms that never change."""
        return {name: getattr(settings, name) for name in self.uniforms}
