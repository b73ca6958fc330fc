"""Whether views can be shown: names, places that exclude each other, paths that are long enough."""

from __future__ import annotations

from collections.abc import Iterator

from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.views import View
from vrcomfort.settings import KeyPath, Problem, repeated


def view_problems(protocol: Protocol, shipped: list[str]) -> Iterator[Problem]:
    """Yield what is wrong with views by themselves; their scenes are looked at elsewhere."""
    yield from repeated(("views",), [view.name for view in protocol.views])
    for index, view in enumerate(protocol.views):
        path: KeyPath = ("views", index)
        if view.name in shipped:
            message = f"`{view.name}` is a shipped scene; give the view another name"
            yield Problem((*path, "name"), message)
        if view.name not in protocol.scenes:
            message = f"no trial shows the view `{view.name}`; name it in `scenes`, or remove it"
            yield Problem((*path, "name"), message)
        places = [key for key in ("viewpoint", "path", "points") if getattr(view, key) is not None]
        if len(places) > 1:
            message = f"`{places[0]}` and `{places[1]}` exclude each other; keep one"
            yield Problem((*path, places[1]), message)
        if view.unwrapped and view.points is None:
            message = "`unwrapped` does nothing without `points`; a side-car says it of its paths"
            yield Problem((*path, "unwrapped"), message)
        if view.points is not None and view.points[-1].time_s < protocol.length_s(view.name):
            yield Problem((*path, "points"), too_short(protocol, view, view.points[-1].time_s))


def too_short(protocol: Protocol, view: View, duration_s: float) -> str:
    """Say that a path ends before its trial."""
    length_s = protocol.length_s(view.name)
    message = f"the path ends after {duration_s:g} s and the trial after {length_s:g} s"
    return f"{message}; add a point, or set the view's `exposure_s`"
