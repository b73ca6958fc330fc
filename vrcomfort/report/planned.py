"""Planned exposures of each condition, and planned times of questionnaires."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Sheet
    from vrcomfort.records.json_file import ManifestShape, PartOfStudy, TrialSequence
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


def planned_exposures(
    study: StudyData, plan: Plan, sheets: list[Sheet], instrument: str
) -> dict[str, int]:
    """Return how many exposures of each condition a participant of the study is to have.

    As the protocol has it, where that asks after each exposure; else what most participants have
    (of two numbers that are as frequent, the larger one: an exposure is lost more easily than one
    is added). One more exposure of somebody never changes what the others need.
    """
    met = Counter((sheet.participant, sheet.condition) for sheet in sheets)
    counts: dict[str, Counter[int]] = defaultdict(Counter)
    for (_, condition), count in met.items():
        counts[condition][count] += 1
    usual = {
        condition: max(found, key=lambda count: (found[count], count))
        for condition, found in counts.items()
    }
    protocol = _of_the_protocol(study, plan, instrument)
    return usual | {c: n for c, n in protocol.items() if c in usual}


def _of_the_protocol(study: StudyData, plan: Plan, instrument: str) -> dict[str, int]:
    """Return the exposures per condition of the sequence, or of the crossing with the scenes."""
    for manifest in reversed(study.manifests):
        settings = manifest.settings
        order = settings.order
        has_scenes = "scenes" in settings.model_fields_set
        if order is None or not has_scenes or not asks_after_exposures(manifest, plan, instrument):
            continue
        if order.rule == "parts":
            groups = [each.name for each in settings.groups]
            return _alike([_of_parts(settings.parts, group) for group in groups or [""]])
        if order.rule != "explicit":
            return {each.name: len(settings.scenes) for each in settings.conditions}
        trials = [Counter(_conditions_of(sequence)) for sequence in order.sequences]
        alike = {c: {found[c] for found in trials} for found in trials for c in found}
        return {c: numbers.pop() for c, numbers in alike.items() if len(numbers) == 1}
    return {}


def asks_after_exposures(manifest: ManifestShape, plan: Plan, instrument: str) -> bool:
    """Return whether a session's protocol asks an instrument after each exposure."""
    wanted = (plan.exposure_timepoint, "after_trial", instrument)
    asked = manifest.settings.questionnaires
    return any(
        (each.timepoint, each.when, each.instrument) == wanted
        and not (each.sessions or each.trials)
        for each in asked
    )


def _alike(groups: list[Counter[str]]) -> dict[str, int]:
    """Return the exposures per condition that all groups have which meet it at all."""
    numbers: dict[str, set[int]] = defaultdict(set)
    for counts in groups:
        for condition, number in counts.items():
            numbers[condition].add(number)
    return {name: each.pop() for name, each in numbers.items() if len(each) == 1}


def _of_parts(parts: list[PartOfStudy], group: str) -> Counter[str]:
    """Return the exposures per condition of written parts; a group's orders have the same trials.

    None are known where a rule makes the orders of a part.
    """
    counts: Counter[str] = Counter()
    for part in parts:
        orders = [each for each in part.orders if not group or each.group in (None, group)]
        if not orders:
            return Counter()
        for trial in orders[0].trials:
            counts[trial.condition] += part.repeats
    return counts


def _conditions_of(sequence: TrialSequence) -> list[str]:
    return [trial.condition for session in sequence.sessions for trial in session]
