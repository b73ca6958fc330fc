"""Checks of a protocol as a whole: names, views, and all other checks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path as FilePath

from vrcomfort.protocol.condition_check import (
    adjustment_problems,
    without_effect,
    written_tables,
)
from vrcomfort.protocol.model import Protocol, trial_counts
from vrcomfort.protocol.order_check import (
    group_problems,
    order_problems,
    part_problems,
    practice_problems,
    unknown_name,
)
from vrcomfort.protocol.questions import free_text_problems, moment_problems
from vrcomfort.protocol.session_steps import break_problems, instruction_problems
from vrcomfort.protocol.viewing import SceneView
from vrcomfort.resources import data_folder
from vrcomfort.settings import KeyPath, Problem, read_toml, repeated, reserved
from vrcomfort.settings.locate import Path
from vrcomfort.settings.reading import did_you_mean


def problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield every fault of a protocol that pydantic has accepted."""
    yield from reserved(("name",), protocol.name)
    if not protocol.conditions:
        message = "there is nothing to show; add a [[conditions]] table, or [[factors]]"
        yield Problem(("conditions",), message, missing=True)
    written = "factors" if protocol.factors else "conditions"
    yield from repeated((written,), _conditions(protocol))
    for index, condition in enumerate(protocol.conditions):
        yield from reserved(("conditions", index, "name"), condition.name)
    yield from repeated(("scenes",), protocol.scenes)
    yield from without_effect(protocol)
    yield from _missing_scenes(protocol)
    yield from _focus_scripts(protocol)
    yield from order_problems(protocol)
    yield from part_problems(protocol)
    yield from group_problems(protocol)
    yield from _simulation(protocol)
    yield from _ratings(protocol)
    yield from _locomotion(protocol)
    yield from instruction_problems(protocol.instructions, folder_of(protocol))
    yield from practice_problems(protocol)
    yield from break_problems(protocol.breaks, protocol.break_s)
    yield from _trials_that_are_not(protocol)
    if protocol.exposure_ends == "task" and not protocol.tasks:
        message = "no exposure has a task that could end it; add [[tasks]], or remove this"
        yield Problem(("exposure_ends",), message)
    yield from adjustment_problems(protocol)
    yield from _consent(protocol)
    yield from repeated(("free_texts",), [each.name for each in protocol.free_texts])
    wordings = {language: table.free_texts for language, table in protocol.text.items()}
    yield from moment_problems("free_texts", protocol.free_texts)
    yield from moment_problems("questionnaires", protocol.questionnaires)
    yield from free_text_problems(protocol.free_texts, protocol.languages, wordings)
    yield from _visibility(protocol)


def folder_of(protocol: Protocol) -> FilePath | None:
    """Return where the files of a protocol are looked for; None where it is none itself."""
    return protocol.file.parent if protocol.file else None


def _missing_scenes(protocol: Protocol) -> Iterator[Problem]:
    shipped = sorted(path.stem for path in data_folder("scenes").glob("*.glb"))
    yield from view_problems(protocol, shipped)
    views = [view.name for view in protocol.views]
    named: list[tuple[Path, str, list[str]]] = [
        (("scenes", index), scene, [*shipped, *views])
        for index, scene in enumerate(protocol.scenes)
        if scene not in views
    ]
    named += [
        (("views", index, "scene"), view.scene, shipped)
        for index, view in enumerate(protocol.views)
    ]
    for path, scene, known in named:
        if scene.endswith((".glb", ".gltf")):
            where = (protocol.file.parent / scene) if protocol.file else None
            if where is not None and not where.is_file():
                yield Problem(path, f"there is no scene file {where}")
        elif scene not in known:
            yield Problem(path, f"there is no scene `{scene}`; {did_you_mean(scene, known)}")


def _focus_scripts(protocol: Protocol) -> Iterator[Problem]:
    for path, table, _ in written_tables(protocol, read_toml(protocol.toml, None)):
        for scene in table.get("focus", {}).get("scripts", {}):
            key = (*path, "focus", "scripts", scene)
            yield from _named_key(key, "scene", protocol.scenes)


def _consent(protocol: Protocol) -> Iterator[Problem]:
    named = protocol.consent.file if protocol.consent else ""
    if named and protocol.file and not (protocol.file.parent / named).is_file():
        message = f"there is no file {protocol.file.parent / named}; write the text there"
        yield Problem(("consent", "file"), message)


def _conditions(protocol: Protocol) -> list[str]:
    return [condition.name for condition in protocol.conditions]


def _simulation(protocol: Protocol) -> Iterator[Problem]:
    effects = protocol.simulation
    for name in effects.condition_effects:
        path: Path = ("simulation", "condition_effects", name)
        yield from _named_key(path, "condition", _conditions(protocol))
    for name in effects.liking:
        path = ("simulation", "liking", name)
        yield from _named_key(path, "condition", _conditions(protocol))
    for name in effects.task_effects:
        path = ("simulation", "task_effects", name)
        yield from _named_key(path, "condition", _conditions(protocol))
    adjusted = [each.name for each in protocol.adjustments]
    for name, wanted in effects.adjusts_to.items():
        yield from _named_key(("simulation", "adjusts_to", name), "adjustment", adjusted)
        for low, high in [each.range for each in protocol.adjustments if each.name == name]:
            if not low <= wanted <= high:
                message = f"{wanted:g} is not in the range of `{name}`, {low:g} to {high:g}"
                yield Problem(("simulation", "adjusts_to", name), f"{message}; choose one that is")
    known = {each.name: each.levels for each in protocol.covariates}
    for name, levels in effects.skill_effects.items():
        yield from _named_key(("simulation", "skill_effects", name), "covariate", known)
        for level in levels if name in known else ():
            path = ("simulation", "skill_effects", name, level)
            yield from _named_key(path, "level", known[name])
    for name in effects.scene_effects:
        yield from _named_key(("simulation", "scene_effects", name), "scene", protocol.scenes)


def _named_key(path: Path, kind: str, known: Iterable[str]) -> Iterator[Problem]:
    for problem in unknown_name(path[:-1], kind, str(path[-1]), known):
        yield Problem(path, problem.message)


def _ratings(protocol: Protocol) -> Iterator[Problem]:
    for index, ratings in enumerate(protocol.ratings):
        for problem in ratings.problems(protocol.longest_s):
            yield Problem(("ratings", index, *problem.path), problem.message)
    yield from repeated(("ratings",), [each.instrument for each in protocol.ratings])


_NEEDS_MODE = {
    "teleport_m": ("teleport",),
    "walking_speed_m_s": ("walk",),
    "turning_deg_s": ("walk", "teleport"),
    "snap_turn_deg": ("walk", "teleport"),
}
"""Keys of [locomotion] that do nothing in other modes."""


def _locomotion(protocol: Protocol) -> Iterator[Problem]:
    walks = protocol.locomotion
    for key in sorted(walks.model_fields_set & _NEEDS_MODE.keys()):
        if walks.mode not in _NEEDS_MODE[key]:
            message = f'`{key}` does nothing with mode = "{walks.mode}"; remove it or change that'
            yield Problem(("locomotion", key), message)


def _trials_that_are_not(protocol: Protocol) -> Iterator[Problem]:
    """Yield numbers of trials, and of sessions, that no participant comes to."""
    sessions, trials = trial_counts(protocol)
    named: list[tuple[Path, str, int, int]] = [
        (("practice", index, "before_trial"), "trial", each.before_trial, trials)
        for index, each in enumerate(protocol.practice)
    ]
    for table in ("practice", "instructions"):
        for index, each in enumerate(getattr(protocol, table)):
            path: Path = (table, index, "sessions")
            named += [((*path, k), "session", n, sessions) for k, n in enumerate(each.sessions)]
    for index, told in enumerate(protocol.instructions):
        path = ("instructions", index, "trials")
        named += [((*path, k), "trial", n, trials) for k, n in enumerate(told.trials)]
    for k, number in enumerate(protocol.breaks.after_trials if protocol.breaks else ()):
        named.append((("breaks", "after_trials", k), "trial", number, trials - 1))
    for index, each in enumerate(protocol.practice):
        if each.draw is not None and each.draw > trials:
            message = f"a session has at most {trials} trials to draw from; draw no more"
            yield Problem(("practice", index, "draw"), message)
    for path, what, number, most in named:
        if number > most >= 0:
            last = "before another" if path[0] == "breaks" else "at all"
            yield Problem(path, f"there is no {what} {number} {last}: at most {most} come")


def _visibility(protocol: Protocol) -> Iterator[Problem]:
    names = _conditions(protocol)
    seen = protocol.visibility
    named: list[tuple[Path, str]] = [
        (("visibility", "unseen", index), name) for index, name in enumerate(seen.unseen)
    ]
    for index, pair in enumerate(seen.alike):
        named += [(("visibility", "alike", index, side), name) for side, name in enumerate(pair)]
    for path, name in named:
        for problem in unknown_name(path, "condition", name, names):
            yield Problem(path, problem.message)


def view_problems(protocol: Protocol, shipped: list[str]) -> Iterator[Problem]:
    """Yield faults of views by themselves; their scenes are checked elsewhere."""
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
        for key in ("unwrapped", "loop"):
            if getattr(view, key) and view.points is None:
                message = f"`{key}` does nothing without `points`; a side-car says it of its paths"
                yield Problem((*path, key), message)
        ends_s = view.points[-1].time_s if view.points and not view.loop else math.inf
        if view.points is not None and ends_s < protocol.length_s(view.name):
            yield Problem((*path, "points"), too_short(protocol, view, view.points[-1].time_s))


def too_short(protocol: Protocol, view: SceneView, duration_s: float) -> str:
    """Say that a path ends before its trial."""
    length_s = protocol.length_s(view.name)
    message = f"the path ends after {duration_s:g} s and the trial after {length_s:g} s"
    return f"{message}; add a point, or set the view's `exposure_s`"
