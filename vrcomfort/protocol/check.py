"""What the types of a protocol cannot say: names that must exist, orders that must be whole."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.without_effect import without_effect
from vrcomfort.resources import data_folder
from vrcomfort.settings import Problem, repeated, reserved
from vrcomfort.settings.hints import did_you_mean
from vrcomfort.settings.locate import Path

_MOST_TREATMENTS = {"williams": 26, "full": 6, "random": 1000}


def problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield every fault of a protocol whose types are right."""
    yield from reserved(("name",), protocol.name)
    yield from repeated(("conditions",), [condition.name for condition in protocol.conditions])
    for index, condition in enumerate(protocol.conditions):
        yield from reserved(("conditions", index, "name"), condition.name)
    yield from repeated(("scenes",), protocol.scenes)
    yield from without_effect(protocol)
    yield from _missing_scenes(protocol)
    yield from _order(protocol)
    yield from _simulation(protocol)
    yield from _ratings(protocol)


def _missing_scenes(protocol: Protocol) -> Iterator[Problem]:
    shipped = sorted(path.stem for path in data_folder("scenes").glob("*.glb"))
    for index, scene in enumerate(protocol.scenes):
        if scene.endswith((".glb", ".gltf")):
            where = (protocol.file.parent / scene) if protocol.file else None
            if where is not None and not where.is_file():
                yield Problem(("scenes", index), f"there is no scene file {where}")
        elif scene not in shipped:
            hint = did_you_mean(scene, shipped)
            yield Problem(("scenes", index), f"there is no scene `{scene}`; {hint}")


def _order(protocol: Protocol) -> Iterator[Problem]:
    order = protocol.order
    if order.rule != "explicit":
        yield from _generated_order(protocol)
        return
    if not order.sequences:
        yield Problem(("order", "rule"), "`explicit` needs at least one [[order.sequences]] table")
    yield from repeated(("order", "sequences"), [each.name for each in order.sequences])
    for index, sequence in enumerate(order.sequences):
        path: Path = ("order", "sequences", index)
        if len(sequence.sessions) != len(order.sequences[0].sessions):
            message = f"sequence `{sequence.name}` has another number of sessions than the first"
            yield Problem((*path, "sessions"), f"{message}; all need the same")
        for session_index, session in enumerate(sequence.sessions):
            for trial_index, trial in enumerate(session):
                place = (*path, "sessions", session_index, trial_index)
                yield from _known(place, "condition", trial.condition, _conditions(protocol))
                yield from _known(place, "scene", trial.scene, protocol.scenes)


def _generated_order(protocol: Protocol) -> Iterator[Problem]:
    order = protocol.order
    if order.sequences:
        message = f"rule `{order.rule}` makes its own sequences; remove these or say `explicit`"
        yield Problem(("order", "sequences"), message)
    treatments = len(protocol.conditions) * len(protocol.scenes)
    most = _MOST_TREATMENTS[order.rule]
    if treatments > most:
        message = f"`{order.rule}` takes at most {most} condition-scene pairs; there are"
        yield Problem(("order", "rule"), f"{message} {treatments}: choose another rule")
    if treatments % order.sessions:
        message = f"{treatments} condition-scene pairs cannot be dealt evenly over"
        yield Problem(("order", "sessions"), f"{message} {order.sessions} sessions")


def _conditions(protocol: Protocol) -> list[str]:
    return [condition.name for condition in protocol.conditions]


def _known(path: Path, kind: str, name: str, known: Iterable[str]) -> Iterator[Problem]:
    choices = list(known)
    if name not in choices:
        hint = did_you_mean(name, choices)
        yield Problem((*path, kind), f"this study has no {kind} `{name}`; {hint}")


def _simulation(protocol: Protocol) -> Iterator[Problem]:
    effects = protocol.simulation
    for name in effects.condition_effects:
        path: Path = ("simulation", "condition_effects", name)
        yield from _named_key(path, "condition", _conditions(protocol))
    for name in effects.scene_effects:
        yield from _named_key(("simulation", "scene_effects", name), "scene", protocol.scenes)


def _named_key(path: Path, kind: str, known: Iterable[str]) -> Iterator[Problem]:
    for problem in _known(path[:-1], kind, str(path[-1]), known):
        yield Problem(path, problem.message)


def _ratings(protocol: Protocol) -> Iterator[Problem]:
    ratings = protocol.ratings
    if ratings and ratings.every_s + ratings.timeout_s > protocol.exposure_s:
        message = "no rating fits into an exposure: every_s + timeout_s is more than exposure_s"
        yield Problem(("ratings",), f"{message}; shorten them, or remove [ratings]")
