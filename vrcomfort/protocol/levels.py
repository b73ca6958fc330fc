"""The trials that a study has to show, and their levels of each factor."""

from __future__ import annotations

from collections import Counter

from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import Group, Part, Trial, orders_of


def trials_of(protocol: Protocol, group: Group | None = None) -> tuple[Trial, ...]:
    """Return every condition-scene pair, or those that a group meets."""
    wanted = group.conditions if group else ()
    return tuple(
        Trial(scene=scene, condition=condition.name)
        for condition in protocol.conditions
        if not wanted or condition.name in wanted
        for scene in protocol.scenes
    )


def part_trials(protocol: Protocol, part: Part, group: Group | None = None) -> tuple[Trial, ...]:
    """Return the condition-scene pairs, or a group's, of a part with orders made by a rule."""
    return tuple(
        trial
        for trial in trials_of(protocol, group)
        if (not part.conditions or trial.condition in part.conditions)
        and (not part.scenes or trial.scene in part.scenes)
    )


def factor_names(protocol: Protocol) -> list[str]:
    """Return the names of the crossed factors."""
    return [factor.name for factor in protocol.factors]


def level_of(protocol: Protocol, trial: Trial, factor: str) -> str:
    """Return the level that a trial has of `condition`, `scene`, `trial` or a crossed factor."""
    if factor == "scene":
        return trial.scene
    if factor == "condition":
        return trial.condition
    if factor == "trial":
        return f"{trial.condition} in {trial.scene}"
    return protocol.condition(trial.condition).levels[factor]


def trial_counts(protocol: Protocol) -> tuple[int, int]:
    """Return how many sessions there are, and how many trials the longest of them has."""
    order = protocol.order
    if order.rule == "explicit":
        sessions = [each.sessions for each in order.sequences]
        lengths = [len(session) for each in sessions for session in each]
        return max(map(len, sessions), default=0), max(lengths, default=0)
    if order.rule == "parts":
        each_group = [_by_session(protocol, group) for group in protocol.groups or (None,)]
        longest = max(max(counts.values(), default=0) for counts in each_group)
        return max(map(len, each_group)), longest
    most = max(len(trials_of(protocol, group)) for group in protocol.groups or (None,))
    return order.sessions, most * order.blocks // order.sessions


def _by_session(protocol: Protocol, group: Group | None) -> Counter[int]:
    """Return how many trials of its parts a group meets in each session."""
    counts = Counter[int]()
    for part in protocol.parts:
        written = orders_of(part, group.name if group else "")
        made = written[0].trials if written else part_trials(protocol, part, group)
        counts[part.session] += len(made) * part.repeats
    return counts
