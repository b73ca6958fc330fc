"""From questionnaires to one row of integer scores per exposure, and who is left out and why."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.report.ordering import natural
from vrcomfort.report.sheet_scores import SheetScores, items_of

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Instrument, Sheet
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

Basis = Literal["difference_from_baseline", "raw_post"]


@dataclass(frozen=True)
class Exposures:
    """Scored exposures.

    Parameters
    ----------
    instrument
        What was asked.
    outcomes
        Its scales that were scored, in the order of the plan.
    table
        One row per exposure with a usable questionnaire: participant, session, position (in the
        session, or among all if sessions have one exposure each), condition, scene, early (1 if
        the exposure was not finished), the outcomes as whole numbers of steps, and the items.
    recovery
        Same columns for the questionnaires after recovery, condition blank.
    excluded
        Questionnaires left out: participant, what, reason.
    planned
        Condition → exposures that a participant of the study has; see `planned_exposures`.
    """

    instrument: Instrument
    outcomes: tuple[str, ...]
    basis: Basis
    table: pd.DataFrame
    recovery: pd.DataFrame
    excluded: tuple[dict[str, str], ...]
    planned: dict[str, int]

    @property
    def weights(self) -> dict[str, float]:
        """Return outcome → points per step."""
        return {s.name: s.weight for s in self.instrument.scales if s.name in self.outcomes}

    @property
    def titles(self) -> dict[str, str]:
        """Return outcome → what readers call it."""
        return {s.name: s.title for s in self.instrument.scales if s.name in self.outcomes}

    @property
    def items(self) -> tuple[str, ...]:
        """Return the names of the items that are columns of the tables."""
        return items_of(self.instrument)


Moment = tuple[str, str, str, str]
"""Participant, session, number of the exposure, condition; blank where it is not said."""


@dataclass(frozen=True)
class _Baselines:
    """Answers before exposure, by the moment they belong to, and the run of the session.

    Each run of a session that was interrupted began with a baseline of its own; None where that
    is incomplete.
    """

    by_moment: dict[Moment, dict[int, Sheet | None]]

    def of(self, sheet: Sheet) -> Sheet | None:
        """Return the baseline nearest to a questionnaire: of its exposure, session, or study."""
        runs = self._nearest(sheet)
        before = [run for run in runs if run <= sheet.run]
        return runs[max(before)] if before else None

    def _nearest(self, sheet: Sheet) -> dict[int, Sheet | None]:
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
    scores = SheetScores(study.instrument, asked, plan.outcomes)
    sheets = _last_runs(asked, plan, excluded)
    whole = [s for s in sheets if _is_whole(s, scores, excluded)]
    baselines = _baselines([s for s in sheets if s.run or scores.is_whole(s)], scores, plan)
    has_baseline = any(s.timepoint == plan.baseline_timepoint for s in kept)
    after = [s for s in whole if s.timepoint != plan.baseline_timepoint]
    table = _table(after, scores, baselines, _facts(study, plan), excluded, has_baseline)
    posts = table["timepoint"] == plan.exposure_timepoint
    met = [s for s in sheets if s.timepoint == plan.exposure_timepoint and s.condition]
    return Exposures(
        instrument=study.instrument,
        outcomes=scores.outcomes,
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
    asked = asked_after_exposures(study, plan)
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


def asked_after_exposures(study: StudyData, plan: Plan) -> dict[str, str]:
    """Return what a protocol says where it asks the study's instrument after each exposure."""
    instrument = study.instrument.name
    return {"timepoint": plan.exposure_timepoint, "when": "after_trial", "instrument": instrument}


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


def _is_whole(sheet: Sheet, scores: SheetScores, excluded: list[dict[str, str]]) -> bool:
    if scores.is_whole(sheet):
        return True
    absent = scores.absent(sheet)
    names = ", ".join(absent[:3]) + (f" and {len(absent) - 3} more" if absent[3:] else "")
    reason = f"incomplete: no answer to {names}" if absent else "incomplete: weights are missing"
    excluded.append(_left_out(sheet, reason))
    return False


def _left_out(sheet: Sheet, reason: str) -> dict[str, str]:
    what = {"participant": sheet.participant, "questionnaire": sheet.name, "reason": reason}
    return {**what, "place": sheet.place}


def _baselines(sheets: list[Sheet], scores: SheetScores, plan: Plan) -> _Baselines:
    """Index the baselines; one with a number that no exposure has is of the whole session."""
    exposures = {_moment(s) for s in sheets if s.timepoint == plan.exposure_timepoint}
    numbered = {(person, session, number) for person, session, number, _ in exposures}
    found: dict[Moment, dict[int, Sheet | None]] = {}
    for sheet in sheets:
        if sheet.timepoint == plan.baseline_timepoint:
            person, session, number, condition = _moment(sheet)
            number = number if (person, session, number) in numbered else ""
            runs = found.setdefault((person, session, number, condition), {})
            runs[sheet.run] = sheet if scores.is_whole(sheet) else None
    return _Baselines(found)


def _moment(sheet: Sheet) -> Moment:
    return sheet.participant, sheet.session, _number(sheet), sheet.condition


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


def _table(
    after: list[Sheet],
    scores: SheetScores,
    baselines: _Baselines,
    facts: _Facts,
    excluded: list[dict[str, str]],
    has_baseline: bool,
) -> pd.DataFrame:
    """Return a row per usable questionnaire, with the changes since its baseline."""
    pairs: list[tuple[Sheet, Sheet | None]] = []
    for sheet in after:
        before = baselines.of(sheet)
        if sheet.timepoint == facts.exposure_timepoint and not sheet.condition:
            excluded.append(_left_out(sheet, "no condition is given"))
        elif has_baseline and before is None:
            excluded.append(_left_out(sheet, "no complete baseline to subtract"))
        else:
            pairs.append((sheet, before))
    whose = [_whose(sheet, facts) for sheet, _ in pairs]
    found = scores.differences([sheet for sheet, _ in pairs], [before for _, before in pairs])
    return pd.DataFrame(whose, columns=list(_COLUMNS)).assign(**found)


def _whose(sheet: Sheet, facts: _Facts) -> dict[str, Any]:
    key = (sheet.participant, sheet.session, _number(sheet))
    trial = facts.trials.get(key, {})
    return {
        "participant": sheet.participant,
        "session": sheet.session,
        "position": facts.positions.get(key, 0),
        "timepoint": sheet.timepoint,
        "condition": sheet.condition,
        "scene": sheet.scene or trial.get("scene", ""),
        "early": int(trial.get("status", "completed") != "completed"),
    }
