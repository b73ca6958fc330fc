"""From questionnaires to one row of integer scores per exposure, and who is left out and why."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import LOADINGS, SSQ, score
from vrcomfort.report.ordering import natural

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Sheet
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

Basis = Literal["difference_from_baseline", "raw_post"]
OUTCOMES = ("T", "N", "O", "D")
ITEMS = tuple(item.name for item in SSQ.items)
_RAW = {"T": "total_raw", "N": "nausea_raw", "O": "oculomotor_raw", "D": "disorientation_raw"}


@dataclass(frozen=True)
class Exposures:
    """Scored exposures.

    Parameters
    ----------
    table
        One row per exposure with a usable questionnaire: participant, session, position (in the
        session, or among all if sessions have one exposure each), condition, scene, early (1 if
        the exposure was not finished), and integer T, N, O, D and items.
    recovery
        Same columns for the questionnaires after recovery, condition blank.
    excluded
        Questionnaires left out: participant, what, reason.
    planned
        Condition → exposures that a participant of the study has; see `planned_exposures`.
    """

    basis: Basis
    table: pd.DataFrame
    recovery: pd.DataFrame
    excluded: tuple[dict[str, str], ...]
    planned: dict[str, int]


Moment = tuple[str, str, str, str]
"""Participant, session, number of the exposure, condition; blank where it is not said."""


@dataclass(frozen=True)
class _Baselines:
    """Answers before exposure, by the moment they belong to, and the run of the session.

    Each run of a session that was interrupted began with a baseline of its own; None where that
    is incomplete.
    """

    by_moment: dict[Moment, dict[int, dict[str, int] | None]]

    def of(self, sheet: Sheet) -> dict[str, int] | None:
        """Return the baseline nearest to a questionnaire: of its exposure, session, or study."""
        runs = self._nearest(sheet)
        before = [run for run in runs if run <= sheet.run]
        return runs[max(before)] if before else None

    def _nearest(self, sheet: Sheet) -> dict[int, dict[str, int] | None]:
        person, number, condition = sheet.participant, _number(sheet), sheet.condition
        keys = (
            (person, session, exposure, name)
            for session in dict.fromkeys((sheet.session, ""))
            for exposure in dict.fromkeys((number, ""))
            for name in dict.fromkeys((condition, ""))
        )
        return next((self.by_moment[key] for key in keys if key in self.by_moment), {})


def score_exposures(study: StudyData, plan: Plan) -> Exposures:
    """Score every questionnaire on integer raw sums, minus the baseline where there is one.

    Nothing of a participant whom the experimenter has excluded is scored.

    Raises
    ------
    InputError
        If the plan's exposure timepoint is not in the data.
    """
    excluded: list[dict[str, str]] = []
    kept = _kept_by_the_experimenter(study)
    _check_timepoints(kept, plan)
    asked = [s for s in kept if s.timepoint in _timepoints(plan)]
    sheets = _last_runs(asked, plan, excluded)
    whole = [s for s in sheets if _is_whole(s, excluded)]
    baselines = _baselines([s for s in sheets if s.run or _answers_all(s)], plan)
    has_baseline = any(s.timepoint == plan.baseline_timepoint for s in kept)
    after = [s for s in whole if s.timepoint != plan.baseline_timepoint]
    facts = _facts(study, plan)
    rows = [_row(s, baselines, facts, excluded, has_baseline=has_baseline) for s in after]
    table = pd.DataFrame([row for row in rows if row], columns=[*_COLUMNS, *OUTCOMES, *ITEMS])
    posts = table["timepoint"] == plan.exposure_timepoint
    met = [s for s in sheets if s.timepoint == plan.exposure_timepoint and s.condition]
    return Exposures(
        basis="difference_from_baseline" if has_baseline else "raw_post",
        table=table[posts].reset_index(drop=True),
        recovery=table[~posts].reset_index(drop=True),
        excluded=tuple(excluded),
        planned=planned_exposures(study, plan, met),
    )


def planned_exposures(study: StudyData, plan: Plan, sheets: list[Sheet]) -> dict[str, int]:
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
    return usual | {c: n for c, n in _of_the_protocol(study, plan).items() if c in usual}


def _of_the_protocol(study: StudyData, plan: Plan) -> dict[str, int]:
    """Return the exposures per condition of the sequence, or of the crossing with the scenes."""
    asked = {"timepoint": plan.exposure_timepoint, "when": "after_trial", "instrument": SSQ.name}
    for manifest in reversed(study.manifests):
        settings = manifest.get("settings") or {}
        order, scenes = settings.get("order"), settings.get("scenes")
        asks = any(asked.items() <= each.items() for each in settings.get("questionnaires", []))
        if not asks or not isinstance(order, dict) or not isinstance(scenes, list):
            continue
        if order.get("rule") != "explicit":
            return {str(each["name"]): len(scenes) for each in settings.get("conditions", [])}
        trials = [Counter(_conditions_of(sequence)) for sequence in order.get("sequences", [])]
        alike = {c: {found[c] for found in trials} for found in trials for c in found}
        return {c: numbers.pop() for c, numbers in alike.items() if len(numbers) == 1}
    return {}


def _conditions_of(sequence: dict[str, Any]) -> list[str]:
    return [str(trial["condition"]) for session in sequence["sessions"] for trial in session]


_COLUMNS = ("participant", "session", "position", "timepoint", "condition", "scene", "early")


def _kept_by_the_experimenter(study: StudyData) -> list[Sheet]:
    """Leave out those whom participants.csv calls excluded; `left_out` gives the reason."""
    gone = {p["participant"] for p in study.participants if p["status"] == "excluded"}
    return [sheet for sheet in study.sheets if sheet.participant not in gone]


def _check_timepoints(sheets: list[Sheet], plan: Plan) -> None:
    """Raise InputError if no questionnaire is from the plan's moment after exposure."""
    found = sorted({sheet.timepoint for sheet in sheets})
    if found and plan.exposure_timepoint not in found:
        raise InputError(
            f"no questionnaire has the timepoint `{plan.exposure_timepoint}` that the analysis "
            f"plan {plan.name} calls exposure_timepoint; the data have {', '.join(found)}"
        )


def unused_timepoints(study: StudyData, plan: Plan) -> list[str]:
    """Say which questionnaires the plan does not use: one of its timepoints may be misspelt."""
    counts = Counter(sheet.timepoint for sheet in study.sheets)
    known = _timepoints(plan)
    return [
        f"{counts[name]} questionnaires at `{name}` are not used: the analysis plan names "
        f"{plan.baseline_timepoint}, {plan.exposure_timepoint} and {plan.recovery_timepoint}"
        for name in sorted(counts.keys() - known)
    ]


def _timepoints(plan: Plan) -> set[str]:
    return {plan.baseline_timepoint, plan.exposure_timepoint, plan.recovery_timepoint}


def _last_runs(sheets: list[Sheet], plan: Plan, excluded: list[dict[str, str]]) -> list[Sheet]:
    """Leave out what was asked again later; but each run of a session needs its baseline."""
    last: dict[tuple[str, ...], int] = {}
    for sheet in sheets:
        moment = (*_moment(sheet), sheet.timepoint)
        last[moment] = max(sheet.run, last.get(moment, 0))

    def counts(sheet: Sheet) -> bool:
        is_last = sheet.run == last[*_moment(sheet), sheet.timepoint]
        return is_last or sheet.timepoint == plan.baseline_timepoint

    reason = "asked again after the session was resumed"
    excluded += [_left_out(sheet, reason) for sheet in sheets if not counts(sheet)]
    return [sheet for sheet in sheets if counts(sheet)]


def _number(sheet: Sheet) -> str:
    return sheet.trial or sheet.period


def _is_whole(sheet: Sheet, excluded: list[dict[str, str]]) -> bool:
    if not _answers_all(sheet):
        absent = [item for item in ITEMS if sheet.answers.get(item) is None]
        names = ", ".join(absent[:3]) + (f" and {len(absent) - 3} more" if absent[3:] else "")
        reason = f"incomplete: no answer to {names}"
        excluded.append(_left_out(sheet, reason))
        return False
    return True


def _answers_all(sheet: Sheet) -> bool:
    return len(sheet.answers) == len(ITEMS) and None not in sheet.answers.values()


def _left_out(sheet: Sheet, reason: str) -> dict[str, str]:
    what = {"participant": sheet.participant, "questionnaire": sheet.name, "reason": reason}
    return {**what, "place": sheet.place}


def _baselines(sheets: list[Sheet], plan: Plan) -> _Baselines:
    """Index the baselines; one with a number that no exposure has is of the whole session."""
    exposures = {_moment(s) for s in sheets if s.timepoint == plan.exposure_timepoint}
    numbered = {(person, session, number) for person, session, number, _ in exposures}
    found: dict[Moment, dict[int, dict[str, int] | None]] = {}
    for sheet in sheets:
        if sheet.timepoint == plan.baseline_timepoint:
            person, session, number, condition = _moment(sheet)
            number = number if (person, session, number) in numbered else ""
            runs = found.setdefault((person, session, number, condition), {})
            runs[sheet.run] = _whole_answers(sheet) if _answers_all(sheet) else None
    return _Baselines(found)


def _moment(sheet: Sheet) -> Moment:
    return sheet.participant, sheet.session, _number(sheet), sheet.condition


def _whole_answers(sheet: Sheet) -> dict[str, int]:
    return {item: answer for item, answer in sheet.answers.items() if answer is not None}


@dataclass(frozen=True)
class _Facts:
    """What other files say about an exposure: (participant, session, number) → fact."""

    exposure_timepoint: str
    positions: dict[tuple[str, str, str], int]
    trials: dict[tuple[str, str, str], dict[str, str]]


def _facts(study: StudyData, plan: Plan) -> _Facts:
    trials = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
    posts = [s for s in study.sheets if s.timepoint == plan.exposure_timepoint]
    exposures = {*trials, *(_moment(s)[:3] for s in posts)}
    return _Facts(plan.exposure_timepoint, _positions(exposures), trials)


def _positions(exposures: set[tuple[str, str, str]]) -> dict[tuple[str, str, str], int]:
    """Place of each exposure in its session, or in the study if sessions have one each."""
    peers: dict[tuple[str, ...], list[tuple[str, str, str]]] = defaultdict(list)
    sessions = {key[:2] for key in exposures}
    depth = 1 if len(sessions) == len(exposures) else 2
    for key in sorted(exposures, key=lambda k: tuple(map(natural, k))):
        if key[1] or key[2]:
            peers[key[:depth]].append(key)
    return {key: place for found in peers.values() for place, key in enumerate(found, start=1)}


def _row(
    sheet: Sheet,
    baselines: _Baselines,
    facts: _Facts,
    excluded: list[dict[str, str]],
    *,
    has_baseline: bool,
) -> dict[str, Any] | None:
    if sheet.timepoint == facts.exposure_timepoint and not sheet.condition:
        excluded.append(_left_out(sheet, "no condition is given"))
        return None
    before = baselines.of(sheet)
    if has_baseline and before is None:
        excluded.append(_left_out(sheet, "no complete baseline to subtract"))
        return None
    key = (sheet.participant, sheet.session, _number(sheet))
    trial = facts.trials.get(key, {})
    zero = dict.fromkeys(ITEMS, 0)
    return {
        "participant": sheet.participant,
        "session": sheet.session,
        "position": facts.positions.get(key, 0),
        "timepoint": sheet.timepoint,
        "condition": sheet.condition,
        "scene": sheet.scene or trial.get("scene", ""),
        "early": int(trial.get("status", "completed") != "completed"),
        **_difference(_whole_answers(sheet), before or zero),
    }


def _difference(after: dict[str, int], before: dict[str, int]) -> dict[str, int]:
    """Integer differences of the raw sums and of each item."""
    one, two = score(after), score(before)
    sums = {name: getattr(one, raw) - getattr(two, raw) for name, raw in _RAW.items()}
    return {**sums, **{item: after[item] - before[item] for item in LOADINGS}}
