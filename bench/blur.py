"""Cost and errors of one kernel of depth of field: every measure of `vrcomfort tradeoff`, at once.

``python -m bench.blur --set samples=36 --size 640x800 --lens 7`` judges the left eye's image of a
place on a shipped walk; ``--size 1832x1920 --window far_edges`` a part of it at a headset's size.
References are kept where `vrcomfort tradeoff` keeps them; ``--samples`` says how good they are.
"""

from __future__ import annotations

import argparse
import os
from typing import Any, get_args

os.environ.setdefault("OMP_NUM_THREADS", "1")

from vrcomfort.protocol.conditions import Condition, DepthOfField
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.costs import time_alone, traffic_of_method
from vrcomfort.tradeoff.error_measures import REGIONS
from vrcomfort.tradeoff.measure import errors_of
from vrcomfort.tradeoff.methods import FOCUS, LENS, BlurMethod, LensName
from vrcomfort.tradeoff.store import Store, default_folder


def main() -> None:
    """Read the command line, measure and print."""
    parser = argparse.ArgumentParser(prog="python -m bench.blur", description=__doc__)
    parser.add_argument("--set", nargs="*", default=[], metavar="NAME=VALUE", dest="settings")
    parser.add_argument("--scene", default="temple")
    parser.add_argument("--pose", type=int, default=1, help="place on the walk, from 1")
    parser.add_argument("--size", default="640x800")
    parser.add_argument("--window", help="part of an image of 1832x1920")
    parser.add_argument("--lens", choices=get_args(LensName), default="3.5")
    parser.add_argument("--samples", type=int, default=512, help="of the reference")
    parser.add_argument("--rounds", type=int, default=3, help="timed frames")
    parser.add_argument("--flicker", action="store_true", help="draws a second reference")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    settings = {name: _value(text) for name, text in (each.split("=") for each in options.settings)}
    lens = DepthOfField(**{**LENS, **settings})
    method = BlurMethod(
        " ".join(options.settings) or "as set by default",
        "depth_of_field",
        "ours",
        Condition(name="looked_at", focus=FOCUS, depth_of_field=lens),
    )
    case = Case(
        options.scene, options.pose - 1, "still", "depth_of_field", options.lens, options.window
    )
    scope = Scope(
        size_px=(width, height),
        samples=options.samples,
        rounds=options.rounds,
        windows=options.window is not None,
        eyes=1,
        flicker=options.flicker,
    )
    _print(method.name, probe(method, case, scope, Store(default_folder())))


def probe(method: BlurMethod, case: Case, scope: Scope, store: Store) -> dict[str, Any]:
    """Return a method's errors, cost and traffic.

    Errors are those of :func:`measure.eye_errors`, and flicker; cost and traffic are those of the
    whole image. Nothing but references is taken from the store or kept in it.
    """
    cost = time_alone(method, case, scope)
    return {
        **errors_of(case, scope, method, store),
        "cost": cost.cost,
        "cost_interval": cost.cost_interval,
        **traffic_of_method(method, case, scope),
    }


def _value(text: str) -> Any:
    try:
        return int(text)
    except ValueError:
        return text


def _print(name: str, row: dict[str, Any]) -> None:
    print(name)
    for key, value in row.items():
        if isinstance(value, float) and (key.endswith("rms") or key in {"seams", "flicker"}):
            print(f"  {key:28} {value * 1e3:.2f} · 10⁻³")
        elif isinstance(value, float):
            print(f"  {key:28} {value:.4g}")
        else:
            print(f"  {key:28} {value}")
    empty = [region for region in REGIONS if row.get(f"{region}_rms") is None]
    print(f"  not in this view: {', '.join(empty) or 'nothing'}")


if __name__ == "__main__":
    main()
