"""Where a participant stands in a trial's scene, and along which path they are carried."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, SceneView
from vrcomfort.protocol.check import too_short
from vrcomfort.scene.camera_path import CameraPath
from vrcomfort.scene.data import Scene
from vrcomfort.scene.defaults import world_bounds
from vrcomfort.scene.load import find_scene
from vrcomfort.scene.side_car import places_of
from vrcomfort.session.interfaces import LoadScene
from vrcomfort.settings import did_you_mean

_LOOKED_AT_EVERY_S = 0.05


@dataclass(frozen=True)
class StartPose:
    """A scene to begin in, and the path, if there is one.

    Parameters
    ----------
    scene
        What a headset is led into: with the view's starting point.
    """

    scene: Any
    path: CameraPath | None = None


@lru_cache(maxsize=4)
def start_pose_of(scene: Any, view: SceneView, *, walks: bool) -> StartPose:
    """Return the start of a view; a scene without a view stays as it is.

    The same view of the same loaded scene is the same object, so that what is made from it (on the
    GPU, for rays) can be kept for its next exposure.

    Parameters
    ----------
    walks
        Whether controls move the participant; never along a path.
    """
    path = _path(scene, view)
    if path is not None:
        return StartPose(replace(scene, spawn=path.pose(0.0), on_foot=False), path)
    if view.viewpoint is not None:
        place = _named(scene.viewpoints, "viewpoint", view.viewpoint, view)
        return StartPose(replace(scene, spawn=place, on_foot=walks))
    return StartPose(scene if walks or scene is None else replace(scene, on_foot=False))


def _path(scene: Scene, view: SceneView) -> CameraPath | None:
    if view.points is not None:
        return CameraPath(view.points, unwrapped=view.unwrapped, loop=view.loop)
    return None if view.path is None else _named(scene.paths, "path", view.path, view)


def _named(there: Mapping[str, Any], kind: str, name: str, view: SceneView) -> Any:
    if name not in there:
        message = f"the side-car of {view.scene} has no {kind} `{name}`"
        raise InputError(f"{message}; {did_you_mean(name, there)}")
    return there[name]


def without_meshes(source: str) -> Scene:
    """Return a scene with its named places and nothing to see.

    Raises
    ------
    InputError
        If there is no such scene, or its side-car is broken.
    """
    file = find_scene(source)
    empty = Scene(file.stem, (), (), ())
    side_car = file.with_suffix(".toml")
    return places_of(empty, side_car) if side_car.is_file() else empty


def place_faults(protocol: Protocol, load_scene: LoadScene | None = None) -> Iterator[InputError]:
    """Yield places that scenes do not have, paths that end too soon and paths that leave the scene.

    Parameters
    ----------
    load_scene
        Loads a whole scene; without it, whether paths stay in their scenes is not looked at.
    """
    for index, view in enumerate(protocol.views):
        key = ("views", index, "path" if view.path else "viewpoint" if view.viewpoint else "points")
        source = protocol.scene_source(view.name)
        try:
            path = _path_of(protocol, view)
        except InputError as error:
            yield protocol.fault(key, error.message)
            continue
        if path is None:
            continue
        if path.loop and not path.closes:
            message = "a path that loops ends where it begins, and turns by whole turns; change its"
            yield protocol.fault(key, f"{message} last point")
        if not path.loop and path.duration_s < protocol.length_s(view.name):
            yield protocol.fault(key, too_short(protocol, view, path.duration_s))
        if load_scene is not None:
            for sentence in _leaves(path, load_scene(source)):
                yield protocol.fault(key, sentence)


def _path_of(protocol: Protocol, view: SceneView) -> CameraPath | None:
    return start_pose_of(without_meshes(protocol.scene_source(view.name)), view, walks=True).path


def shortened_turns(protocol: Protocol) -> Iterator[str]:
    """Yield a sentence for each step of 180 degrees or more that a path does not turn as written.

    Views that `place_faults` refuses are passed over.
    """
    for view in protocol.views:
        try:
            path = _path_of(protocol, view)
        except InputError:
            continue
        where = f"[paths.{view.path}] of the side-car" if view.path else f"the view `{view.name}`"
        for turn in path.shortened if path else ():
            yield (
                f"{where}: from point {turn.number} to point {turn.number + 1} `yaw_deg` goes from "
                f"{turn.from_deg:g} to {turn.to_deg:g}, but headings turn the shorter way, here by "
                f"{turn.turned_deg:.0f} degrees; write `unwrapped = true` there to turn by "
                f"{turn.to_deg - turn.from_deg:g}"
            )


def _leaves(path: CameraPath, scene: Scene) -> Iterator[str]:
    """Yield a sentence where a path first lies outside the box around a scene."""
    lower, upper = world_bounds(scene)
    count = int(path.duration_s / _LOOKED_AT_EVERY_S) + 2
    times_s = np.linspace(0.0, path.duration_s, count)
    positions = path.positions(times_s)
    outside = ((positions < lower) | (positions > upper)).any(axis=1)
    if outside.any():
        first = int(np.argmax(outside))
        at = ", ".join(f"{value:.2f}" for value in positions[first])
        box = " to ".join(f"[{', '.join(f'{v:.2f}' for v in corner)}]" for corner in (lower, upper))
        message = f"the path leaves the scene after {times_s[first]:.2f} s, at [{at}]"
        yield f"{message}; the scene is {box}: move the points there"
