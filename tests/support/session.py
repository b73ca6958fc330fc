"""The small study's participant, run through its sessions and read back."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import vrcomfort.session
from tests.support.study import AheadHeadset, LateFocus, read_rows, tiny_protocol
from vrcomfort.protocol import Protocol
from vrcomfort.records import read_participants, session_folder
from vrcomfort.respondent import Respondent
from vrcomfort.session import RunOutcome, SessionSettings


def run(
    protocol: Protocol,
    participant: str,
    *,
    study: Path,
    respondent: Respondent,
    seed: int | None = None,
    sessions: Iterable[int] | None = None,
    exposure_s: float | None = None,
    resume: bool = False,
    group_readable: bool = False,
    **parts: Any,
) -> RunOutcome:
    """Enrol a participant and run their sessions."""
    with vrcomfort.session.open_enrolment(
        protocol,
        participant,
        study=study,
        respondent=respondent.name,
        seed=seed,
        sessions=sessions,
        exposure_s=exposure_s,
        resume=resume,
        group_readable=group_readable,
    ) as enrolment:
        settings = SessionSettings(respondent=respondent, **parts)
        return vrcomfort.session.run(enrolment, settings)


def go(tmp_path: Path, respondent, *, headset=AheadHeadset, **more) -> RunOutcome:
    protocol = tiny_protocol(tmp_path)
    return run(
        protocol,
        more.pop("participant", "P01"),
        study=tmp_path / more.pop("study", "S"),
        load_scene=lambda source: f"scene {Path(source).name}",
        headset_for=lambda *_: headset(),
        renderer=more.pop("renderer", LateFocus()),
        respondent=respondent,
        **more,
    )


def rows(tmp_path: Path, name: str, session: int = 1, study: str = "S") -> list[dict[str, str]]:
    return read_rows(session_folder(tmp_path / study, "P01", session) / name)


def manifest(tmp_path: Path, session: int = 1) -> dict:
    folder = session_folder(tmp_path / "S", "P01", session)
    return json.loads((folder / "manifest.json").read_text())


def status(tmp_path: Path) -> tuple[str, str]:
    (row,) = read_participants(tmp_path / "S")
    return row.status, row.note
