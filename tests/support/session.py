"""The small study's participant, run through its sessions and read back."""

from __future__ import annotations

import json
from pathlib import Path

from tests.support.study import AheadHeadset, LateFocus, read_rows, tiny_protocol
from vrcomfort.records import read_participants, session_folder
from vrcomfort.session import Outcome, run


def go(tmp_path: Path, respondent, *, headset=AheadHeadset, **more) -> Outcome:
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
