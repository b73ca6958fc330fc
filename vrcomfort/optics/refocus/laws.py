"""The refocus laws there are."""

from __future__ import annotations

from vrcomfort.optics.refocus import (
    duration,
    instant,
    linear,
    linear_dioptre,
    low_pass,
    low_pass_backward_euler,
)

_LAWS = (
    linear.LAW,
    linear_dioptre.LAW,
    low_pass.LAW,
    low_pass_backward_euler.LAW,
    duration.LAW,
    instant.LAW,
)
LAWS = {each.name: each for each in _LAWS}
"""By name."""
