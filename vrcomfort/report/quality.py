"""What the records say about the quality of the data."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

from vrcomfort.csv_table import whole_or_none
from vrcomfort.report.outcomes import known_outcomes
from vrcomfort.report.stimulus_time import recorded_states

if TYPE_CHECKING:
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


def quality(study: StudyData, scored: Exposures, plan: Plan, unused: list[str]) -> dict[str, Any]:
    """Collect counts and sentences for the section on data quality."""
    return {
        "questionnaire_files": study.files,
        "questionnaires": len(study.sheets),
        "excluded_questionnaires": [*scored.excluded, *_never_asked(study, plan)],
        "scored_after_early_end": _after_early_end(scored),
        "reading": [*study.warnings, *unused],
        "frames": _frames(study),
        "ratings": _ratings(study),
        "sessions": _sessions(study),
        "protocol_versions": _protocol_versions(study),
        "simulated": sum(m.get("respondent") == "simulated" for m in study.manifests),
        "clamps": _clamps(study),
    }


def _after_early_end(scored: Exposures) -> int:
    """Count the scored questionnaires after exposures that were not finished."""
    scores = [name for name, basis in scored.bases.items() if basis != "measured"]
    asked = scored.table[scores].notna().any(axis=1)
    return int(scored.table.loc[asked, "early"].sum())


def _frames(study: StudyData) -> dict[str, Any] | None:
    frames = sum(whole_or_none(t.get("frames")) or 0 for t in study.trials)
    dropped = sum(whole_or_none(t.get("dropped")) or 0 for t in study.trials)
    if not frames:
        return None
    trust = sorted({str(m["timing_trust"]) for m in study.manifests if m.get("timing_trust")})
    return {"shown": frames, "dropped": dropped, "timing_trust": trust, **_seen(study)}


def _seen(study: StudyData) -> dict[str, float]:
    """Add up what was seen in how many seconds, over the trials that say so."""
    said = [trial for trial in study.trials if trial.get("live_s")]
    names = recorded_states(study) if said else ()
    return {name: sum(float(trial[name] or 0) for trial in said) for name in names}


def _never_asked(study: StudyData, plan: Plan) -> list[dict[str, str]]:
    """Return completed exposures after which a question was due, and nothing was answered."""
    answered = {
        (s.participant, s.session, s.trial)
        for s in study.sheets
        if s.timepoint == plan.exposure_timepoint
    }
    asking = _asking_sessions(study, plan)
    return [
        {
            "participant": trial["participant"],
            "questionnaire": f"session {trial['session']}, exposure {trial['trial']}, "
            f"{trial['condition']}, {plan.exposure_timepoint}",
            "reason": "no question was answered after this exposure",
            "place": f"sub-{trial['participant']}/ses-{trial['session']}/questionnaires.csv",
        }
        for trial in study.trials
        if trial["status"] == "completed"
        and (trial["participant"], trial["session"]) in asking
        and (trial["participant"], trial["session"], trial["trial"]) not in answered
    ]


def _asking_sessions(study: StudyData, plan: Plan) -> set[tuple[str, str]]:
    """Return (participant, session) of those whose protocol asks after each exposure."""
    known = known_outcomes(study.instruments.values())
    asked_first = next((known[name] for name in plan.outcomes if name in known), None)
    if asked_first is None:
        return set()
    instrument = asked_first.instrument
    asked = {"timepoint": plan.exposure_timepoint, "when": "after_trial", "instrument": instrument}
    return {
        (str(manifest.get("participant")), str(manifest.get("session")))
        for manifest in study.manifests
        if any(
            asked.items() <= ask.items()
            for ask in manifest.get("settings", {}).get("questionnaires", [])
        )
    }


def _ratings(study: StudyData) -> dict[str, int] | None:
    if not study.ratings:
        return None
    missed = sum(bool(whole_or_none(r.get("missed"))) for r in study.ratings)
    return {"asked": len(study.ratings), "missed": missed}


def _sessions(study: StudyData) -> dict[str, int]:
    return dict(sorted(Counter(str(m.get("status", "")) for m in study.manifests).items()))


def _protocol_versions(study: StudyData) -> int:
    """Count the texts of the protocol under which sessions were recorded."""
    return len({manifest["protocol"]["sha256"] for manifest in study.manifests})


def _clamps(study: StudyData) -> list[dict[str, Any]]:
    """Every clamp that touched a stimulus, with the number of sessions that had it."""
    counts = Counter(str(c) for m in study.manifests for c in m.get("clamps", []))
    return [{"clamp": text, "sessions": n} for text, n in sorted(counts.items())]
