"""Refocus laws: how focus follows its target from frame to frame.

Each law moves focus by the time since the frame before, at any frame rate. All but
`low_pass_backward_euler` are exact: two steps are the same as one of their summed length, so
neither frame rate nor dropped frames change how fast focus moves.

A new law is its settings (`vrcomfort.protocol.conditions.Focus`), a `RefocusLaw` in `LAWS`, its
GLSL in ``shaders/include``, and the GLSL's twin in ``tests/oracles/refocus.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

AT_ONCE = 3e38
"""A step of any law that reaches every target: focus after a cut. Nearly the largest float32."""


@dataclass(frozen=True)
class RefocusLaw:
    """Step size of a law, and the shader that makes the step.

    Parameters
    ----------
    name
        Value of `law` in a protocol.
    step
        From the seconds since the frame before, and the settings by name, how far focus may move,
        in the unit that `glsl` takes.
    glsl
        File of ``shaders/include``: the function ``refocused(current, target)``, in metres, and its
        uniform `step_size`.
    step_settings
        The settings that `step` takes.
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
        """Return the settings that the law reads."""
        return frozenset((*self.step_settings, *self.uniforms))

    def step_size(self, settings: Any, dt_s: float) -> float:
        """Return how far focus may move in `dt_s`."""
        return self.step(dt_s, **{name: getattr(settings, name) for name in self.step_settings})

    def constants(self, settings: Any) -> dict[str, float]:
        """Return the uniforms that never change."""
        return {name: getattr(settings, name) for name in self.uniforms}


def _linear_m(dt_s: float, *, infinity_m: float, refocus_s: float) -> float:
    """Return metres: `infinity_m` in `refocus_s`.

    60 km/s for 30 km in 500 ms, 16.7 µs per metre (Carnegie & Rhee 2015; the printed 1.7 µs is a
    slip). Within a room that is instant.
    """
    return infinity_m / refocus_s * dt_s


def _linear_dioptre(dt_s: float, *, refocus_s: float) -> float:
    """Return dioptres: 1 D in `refocus_s`.

    2 D/s, from the sky to 1 m in 500 ms, is in the physiology that Carnegie & Rhee 2015 cite.
    """
    return dt_s / refocus_s


def low_pass_share(dt_s: float, cutoff_hz: float) -> float:
    """Return the share of the way to the target: 1 − exp(−Δt/τ).

    A first-order low-pass over metres in continuous time (Hillaire et al. 2008, Eq. 4). The share
    that is left falls by e in τ = 1/(2π·f_c), 31.8 ms for 5 Hz. The paper prints τ = (π·f_c)/2,
    which is no time.
    """
    return -math.expm1(-dt_s * math.tau * cutoff_hz)


def backward_euler_share(dt_s: float, cutoff_hz: float) -> float:
    """Return the share of the way to the target: Δt / (Δt + τ).

    The paper's discrete filter over metres (Hillaire et al. 2008, Eq. 4). At its 70 Hz it is 3 dB
    down at 4.2 Hz, not at 5, and at other frame rates elsewhere: :func:`low_pass_share` is the
    filter that it stands for.
    """
    return dt_s / (dt_s + 1 / (math.tau * cutoff_hz))


def _elapsed_s(dt_s: float) -> float:
    """Return the seconds of a change that have passed.

    Every change of focus takes `duration_s`, near or far (Mantiuk et al. 2011, 370 ms). The paper
    gives no shape; ours is linear in dioptres, the eye's own unit. A change begins when the target
    is further than `refixation_dioptre` from the one for which the last change began, also on the
    way: focus then goes from where it is, in `duration_s`, to the new target. A target that moves
    less is followed: on the way the change ends at it on time, afterwards focus stays on it.
    """
    return dt_s


def _instant_m(_: float) -> float:
    """Return more metres than there are."""
    return AT_ONCE


_LAWS = (
    RefocusLaw("linear", _linear_m, "refocus_metres.glsl", ("infinity_m", "refocus_s")),
    RefocusLaw("linear_dioptre", _linear_dioptre, "refocus_dioptres.glsl", ("refocus_s",)),
    RefocusLaw("low_pass", low_pass_share, "refocus_share.glsl", ("cutoff_hz",)),
    RefocusLaw(
        "low_pass_backward_euler", backward_euler_share, "refocus_share.glsl", ("cutoff_hz",)
    ),
    RefocusLaw(
        "duration",
        _elapsed_s,
        "refocus_duration.glsl",
        uniforms=("duration_s", "refixation_dioptre"),
        remembers=True,
    ),
    RefocusLaw("instant", _instant_m, "refocus_metres.glsl"),
)
LAWS = {each.name: each for each in _LAWS}
"""By name."""
