"""Comfort experiments for stereo head-mounted displays.

    import vrcomfort

    study = vrcomfort.simulate_study("smoke", "pilot", participants=8)
    scores = study.scores("ssq")
    vrcomfort.stats.wilcoxon(scores, dv="total", within="condition", subject="participant")

Importing this package loads no other module: each function's module is imported when the function
is first named. Nothing here needs a GPU or an OpenXR runtime until a view is drawn.
"""

from importlib import import_module
from typing import Any

__version__ = "0.2.0"

# Where each public name lives. No name equals that of a subpackage, whose import would replace it;
# `stats` is the subpackage itself. `__init__.pyi` has the same names for editors and type checkers.
_PLACES = {
    "InputError": "vrcomfort.errors",
    "load_plan": "vrcomfort.api.reports",
    "load_protocol": "vrcomfort.protocol",
    "read_study": "vrcomfort.api.reports",
    "render_views": "vrcomfort.api.views",
    "score_answers": "vrcomfort.api.answers",
    "simulate_study": "vrcomfort.api.simulation",
    "write_report": "vrcomfort.api.reports",
}

__all__ = [
    "InputError",
    "__version__",
    "load_plan",
    "load_protocol",
    "read_study",
    "render_views",
    "score_answers",
    "simulate_study",
    "stats",
    "write_report",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first used."""
    if name == "stats":
        return import_module("vrcomfort.stats")
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(_PLACES[name]), name)
    return found


def __dir__() -> list[str]:
    """Return all names, those that are not imported yet among them."""
    return sorted({*globals(), *__all__})
