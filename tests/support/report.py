"""Small studies for report tests: the columns of a study folder, and the minimal foreign form."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import vrcomfort.report
from tests.support import drawn
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.records import ParticipantRow, QuestionnaireRow, TrialRow
from vrcomfort.report import Form, ReportSummary
from vrcomfort.report.build import choose_plan
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.results import analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study

HEAD = 'name = "p"\ntitle = "P"\n'
WITHOUT_MODELS = "mixed_model = []\nanova = []\n"
ONE_SCORE = f'outcomes = ["T"]\n{WITHOUT_MODELS}'
"""Lines of a plan for the total score alone, without models: a third of the work of a report."""


def build_report(
    source: Path, *, out: Path, forms: Sequence[Form] = (), **more: Any
) -> ReportSummary:
    """Build a report, without figures unless a test or ``pytest --draw`` asks for them."""
    return vrcomfort.report.build_report(source, out=out, forms=forms or drawn.FORMS, **more)


def planned_report(source: Path, *, out: Path, lines: str = ONE_SCORE) -> ReportSummary:
    """Build a report by a plan of these lines, which is written beside its folder."""
    plan = out.with_suffix(".toml")
    plan.write_text(HEAD + lines, "utf-8")
    return build_report(source, plan=plan, out=out)


def analysed(source: Path, lines: str | None = None) -> dict[str, Any]:
    """Return results without a page, by a plan of these lines or by the one that is chosen."""
    study = read_study(source)
    plan = choose_plan(study, None) if lines is None else read_plan(HEAD + lines, None)
    found: dict[str, Any] = as_json(analyse(study, plan)[0])
    return found


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def results_of(summary: ReportSummary) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(summary.results.read_text("utf-8"))
    return found


SSQ = shipped_instruments()["ssq"]
ITEMS = tuple(item.name for item in SSQ.items)


def answers(total: int) -> dict[str, int]:
    """Answers whose items sum to `total` (at most 48), from the first item on."""
    left = [max(0, min(3, total - 3 * i)) for i in range(len(ITEMS))]
    return dict(zip(ITEMS, left, strict=True))


def write_csv(path: Path, columns: tuple[str, ...], rows: list[dict[str, object]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, columns, restval="", lineterminator="\r\n")
        writer.writeheader()
        writer.writerows(rows)


def foreign(path: Path, scores: dict[str, dict[str, int]], **more: str) -> Path:
    """One file with participant, condition, item, response: raw scores, no baseline."""
    rows = [
        {"participant": person, "condition": condition, "item": item, "response": answer, **more}
        for person, conditions in scores.items()
        for condition, total in conditions.items()
        for item, answer in answers(total).items()
    ]
    write_csv(path, ("participant", "condition", "item", "response", *more), rows)
    return path


def manifest(participant: str, **more: object) -> str:
    """Return the text of the manifest of somebody's first session."""
    content = {
        "participant": participant, "session": 1, "sequence": "ab", "status": "completed",
        "started_at": "2026-01-01T10:00:00+00:00", "seed": 0, "respondent": "terminal",
        "exposure_s": 90.0, "timing_flags": [], "protocol": {"name": "tiny", "sha256": "0"},
    }  # fmt: skip
    return json.dumps(content | more, indent=1)


@dataclass
class Study:
    """A study folder in the making."""

    folder: Path
    people: list[dict[str, object]] = field(default_factory=list)

    def describe(self, protocol: str, **conditions: str) -> None:
        text = json.dumps({"name": "A study", "protocol": protocol, "conditions": conditions})
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "dataset_description.json").write_text(text)

    def person(self, name: str, sequence: str, status: str = "completed", note: str = "") -> None:
        self.people.append(
            {"participant": name, "sequence": sequence, "status": status, "note": note}
        )
        write_csv(self.folder / "participants.csv", ParticipantRow.columns(), self.people)

    def session(
        self,
        name: str,
        number: int,
        baseline: int | None,
        exposures: list[tuple[str, str, int | None]],
        status: str = "completed",
        place: str | None = None,
    ) -> Path:
        """Write a session: exposures are (condition, scene, total or None for no answer).

        `status` is that of the last exposure, `place` the participant's folder if it has not
        their name.
        """
        trials, asked = [], []
        if baseline is not None:
            asked += _sheet(name, number, baseline, timepoint="baseline")
        for trial, (condition, scene, total) in enumerate(exposures, start=1):
            last = trial == len(exposures)
            trials.append({
                "participant": name, "session": number, "period": trial, "block": 1,
                "trial": trial, "condition": condition, "scene": scene, "start_s": 100.0 * trial,
                "end_s": 100.0 * trial + (40.0 if last and status != "completed" else 90.0),
                "status": status if last else "completed", "frames": 100, "dropped": 2,
            })  # fmt: skip
            if total is not None:
                where = {"period": trial, "block": 1, "trial": trial, "condition": condition}
                asked += _sheet(name, number, total, timepoint="post", **where)
        folder = self.folder / (place or f"sub-{name}") / f"ses-{number}"
        write_csv(folder / "trials.csv", TrialRow.columns(), trials)
        write_csv(folder / "questionnaires.csv", QuestionnaireRow.columns(), asked)
        return folder


def _sheet(name: str, session: int, total: int, **where: object) -> list[dict[str, object]]:
    return [
        {"participant": name, "session": session, "instrument": "ssq", "item": item,
         "response": answer, "asked_s": 1.0, "answered_s": 2.0, "order": order, **where}
        for order, (item, answer) in enumerate(answers(total).items(), start=1)
    ]  # fmt: skip


def carnegie_like(folder: Path, people: int = 8) -> Study:
    """Some people, two sessions with two conditions and scenes each; the fifth and eighth leave."""
    study = Study(folder)
    study.describe("carnegie_2015", dof_off="No blur", dof_on="Blur")
    for i in range(people):
        name, off_first = f"P{i + 1:02d}", i % 2 == 0
        one, two = ("dof_off", "dof_on") if off_first else ("dof_on", "dof_off")
        extra = {"dof_off": 4 + i % 4, "dof_on": 1 + i % 3}
        base = i % 3
        if name == "P05":
            study.session(name, 1, base, [(one, "temple", None)], status="withdrawn")
            study.person(name, "off", "withdrawn", "session 1: too sick")
            continue
        study.session(name, 1, base, [
            (one, "temple", base + extra[one]), (two, "mountain", base + extra[two] + 1),
        ])  # fmt: skip
        if name == "P08":
            study.session(name, 2, base, [(one, "mountain", base + 2)], status="stopped")
            study.person(name, "on", "withdrawn", "session 2: too sick")
            continue
        study.session(name, 2, base, [
            (one, "mountain", base + extra[one]), (two, "temple", base + extra[two]),
        ])  # fmt: skip
        study.person(name, "off" if off_first else "on")
    return study
