"""Facts on an exposure from other files of a study: position, trial, participants."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from vrcomfort.records.names import natural
from vrcomfort.report.baselines import moment_of, number_of

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Sheet
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

Cell = str | int | float | Fraction | None
Row = dict[str, Cell]
"""Column → cell of an exposure: what it is of, and its scores and answers."""
RowKey = tuple[Cell, ...]
SAME_EXPOSURE = (
    "participant", "session", "number", "timepoint", "condition", "scene", "part",
)  # fmt: skip
"""The columns that are alike in rows of one exposure."""
Exposure = tuple[str, str, str]
"""Participant, session, number."""
BETWEEN = ("sequence", "group")
"""Columns that may stand beside answers, and are the same in all of somebody's."""


@dataclass(frozen=True)
class Facts:
    """Facts by exposure, and by participant."""

    positions: dict[Exposure, int]
    trials: dict[Exposure, dict[str, str]]
    conditions: dict[tuple[str, str], set[str]]
    """Participant, session → the conditions met in it."""
    people: dict[str, dict[str, str]]
    """Participant → column → value, of participants.csv and `BETWEEN`."""

    @classmethod
    def of(cls, study: StudyData, plan: Plan) -> Facts:
        """Collect the facts of a study."""
        trials = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
        posts = [s for s in study.sheets if s.timepoint == plan.exposure_timepoint]
        conditions: dict[tuple[str, str], set[str]] = defaultdict(set)
        met = [(t["participant"], t["session"], t["condition"]) for t in study.trials]
        met += [(s.participant, s.session, s.condition) for s in posts if s.condition]
        for who, session, condition in met:
            conditions[who, session].add(condition)
        exposures = {*trials, *(moment_of(s)[:3] for s in posts)}
        exposures |= {
            (row["participant"], row.get("session", ""), row["trial"])
            for row in study.tasks
            if row.get("trial")
        }
        return cls(_positions(exposures), trials, conditions, _people(study))

    def row(self, sheet: Sheet) -> Row:
        """Return the columns of a questionnaire's row that are not scores."""
        key = (sheet.participant, sheet.session, number_of(sheet))
        trial = self.trials.get(key, {})
        person = self.people.get(sheet.participant, {})
        return {
            "participant": sheet.participant,
            "session": sheet.session,
            "number": number_of(sheet),
            "position": self.positions.get(key, 0),
            "timepoint": sheet.timepoint,
            "condition": sheet.condition or self._only_condition(sheet),
            "scene": sheet.scene or trial.get("scene", ""),
            "part": sheet.keys.get("part", "") or trial.get("part", ""),
            "early": int(trial.get("status", "completed") != "completed"),
            **{name: person.get(name, "") for name in BETWEEN},
        }

    def _only_condition(self, sheet: Sheet) -> str:
        """Return the only condition of a session, for questionnaires at its end."""
        met = self.conditions.get((sheet.participant, sheet.session), set())
        return next(iter(met)) if len(met) == 1 else ""


def _people(study: StudyData) -> dict[str, dict[str, str]]:
    found: dict[str, dict[str, str]] = defaultdict(dict)
    columns = {name for person in study.participants for name in person} - {"participant"}
    for column in sorted(columns | set(BETWEEN)):
        for who, value in study.between(column).items():
            found[who][column] = value
    return found


def _positions(exposures: set[Exposure]) -> dict[Exposure, int]:
    """Place of each exposure in its session, or in the study if sessions have one each."""
    peers: dict[tuple[str, ...], list[Exposure]] = defaultdict(list)
    sessions = {key[:2] for key in exposures}
    depth = 1 if len(sessions) == len(exposures) else 2
    for key in sorted(exposures, key=lambda k: tuple(map(natural, k))):
        if key[1] or key[2]:
            peers[key[:depth]].append(key)
    return {key: place for found in peers.values() for place, key in enumerate(found, start=1)}
