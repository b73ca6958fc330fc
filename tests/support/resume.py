"""One session of the small study, run, interrupted and read back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.support.session import run
from tests.support.study import AheadHeadset, LateFocus, Scripted, read_rows, tiny_protocol
from vrcomfort.session import RunOutcome


def go(tmp_path: Path, respondent: Any = None, **more: Any) -> RunOutcome:
    """Run session 1 of P01, or of `participant`; `interrupt` is (exposure, frame), or None."""
    exposure, at_frame = more.pop("interrupt", None) or (0, None)
    begun = []

    def headset_for(*_: object) -> AheadHeadset:
        begun.append(1)
        return AheadHeadset(interrupt_at=at_frame if len(begun) == exposure else None)

    return run(
        more.pop("protocol", None) or tiny_protocol(tmp_path),
        more.pop("participant", "P01"),
        study=tmp_path / more.pop("study", "S"),
        load_scene=lambda source: source,
        headset_for=more.pop("headset_for", headset_for),
        renderer=more.pop("renderer", None) or LateFocus(),
        respondent=respondent or Scripted(),
        sessions=more.pop("sessions", [1]),
        **more,
    )


def folder(tmp_path: Path, study: str = "S") -> Path:
    return tmp_path / study / "sub-P01" / "ses-1"


def rows(tmp_path: Path, name: str) -> list[dict[str, str]]:
    return read_rows(folder(tmp_path) / f"{name}.csv")


def manifest(tmp_path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder(tmp_path) / "manifest.json").read_text())
    return content


def attempts(tmp_path: Path) -> list[tuple[str, ...]]:
    columns = ("trial", "attempt", "resumed", "status", "abort_code")
    return [tuple(row[column] for column in columns) for row in rows(tmp_path, "trials")]
