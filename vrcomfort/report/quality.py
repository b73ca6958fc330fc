"""What the records say about the quality of the data."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.study_data import StudyData


def quality(study: StudyData, scored: Exposures, unused: list[str]) -> dict[str, Any]:
    """Collect counts and sentences for the section on data quality."""
    return {
        "questionnaire_files": study.files,
        "questionnaires": len(study.sheets),
        "excluded_questionnaires": list(scored.excluded),
        "scored_after_early_end": int(scored.table["early"].sum()),
        "reading": [*study.warnings, *unused],
        "frames": _frames(study),
        "ratings": _ratings(study),
        "sessions": _sessions(study),
        "protocol_versions": _protocol_versions(study),
        "simulated": sum(m.get("respondent") == "simulated" for m in study.manifests),
        "clamps": _clamps(study),
    }


def _frames(study: StudyData) -> dict[str, Any] | None:
    frames = sum(_whole(t.get("frames")) for t in study.trials)
    dropped = sum(_whole(t.get("dropped")) for t in study.trials)
    if not frames:
        return None
    trust = sorted({str(m["timing_trust"]) for m in study.manifests if m.get("timing_trust")})
    return {"shown": frames, "dropped": dropped, "timing_trust": trust}


def _ratings(study: StudyData) -> dict[str, int] | None:
    if not study.ratings:
        return None
    missed = sum(_whole(r.get("missed")) for r in study.ratings)
    return {"asked": len(study.ratings), "missed": missed}


def _sessions(study: StudyData) -> dict[str, int]:
    return dict(sorted(Counter(str(m.get("status", "")) for m in study.manifests).items()))


def _protocol_versions(study: StudyData) -> int:
    """Count the texts of the protocol under which sessions were recorded."""
    texts = [m["protocol"] for m in study.manifests if isinstance(m.get("protocol"), dict)]
    return len({text.get("sha256") for text in texts})


def _clamps(study: StudyData) -> list[dict[str, Any]]:
    """Every clamp that touched a stimulus, with the number of sessions that had it."""
    counts = Counter(str(c) for m in study.manifests for c in m.get("clamps") or [])
    return [{"clamp": text, "sessions": n} for text, n in sorted(counts.items())]


def _whole(text: str | None) -> int:
    return int(text) if text and text.lstrip("-").isdigit() else 0
