"""Quality of the data, from a study's records."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vrcomfort.csv_table import whole_or_none
from vrcomfort.report.asked import Unscored
from vrcomfort.report.outcomes import known_outcomes
from vrcomfort.report.planned import asks_after_exposures
from vrcomfort.report.rows import INLINE
from vrcomfort.report.stimulus_time import recorded_states
from vrcomfort.report.study_data import SIMULATED

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


@dataclass(frozen=True)
class ShownFrames:
    """Frames of all exposures; `seconds` has a state of seen time → seconds, where recorded."""

    shown: int
    dropped: int
    timing_trust: tuple[str, ...]
    seconds: dict[str, float] = field(metadata=INLINE)


@dataclass(frozen=True)
class AskedRatings:
    """Ratings that fell due during exposures, and those of them without an answer."""

    asked: int
    missed: int


@dataclass(frozen=True)
class StimulusClamp:
    """A limit that touched a stimulus, and the number of sessions with it."""

    clamp: str
    sessions: int


@dataclass(frozen=True)
class Quality:
    """Counts and sentences for the section on data quality; key `quality` of results.json.

    Parameters
    ----------
    reading
        What was left out while reading.
    sessions
        Status → number of sessions.
    """

    questionnaire_files: int
    questionnaires: int
    excluded_questionnaires: tuple[Unscored, ...]
    scored_after_early_end: int
    reading: tuple[str, ...]
    frames: ShownFrames | None
    ratings: AskedRatings | None
    sessions: dict[str, int]
    protocol_versions: int
    simulated: int
    clamps: tuple[StimulusClamp, ...]


def quality(study: StudyData, scored: Exposures, plan: Plan, reading: Iterable[str]) -> Quality:
    """Collect counts and sentences for the section on data quality.

    Parameters
    ----------
    reading
        What was left out, beside the warnings of the study.
    """
    return Quality(
        questionnaire_files=study.files,
        questionnaires=len(study.sheets),
        excluded_questionnaires=(*scored.excluded, *_never_asked(study, plan)),
        scored_after_early_end=_after_early_end(scored),
        reading=(*study.warnings, *reading),
        frames=_frames(study),
        ratings=_ratings(study),
        sessions=_sessions(study),
        protocol_versions=_protocol_versions(study),
        simulated=sum(each.respondent == SIMULATED for each in study.manifests),
        clamps=_clamps(study),
    )


def _after_early_end(scored: Exposures) -> int:
    """Count the scored questionnaires after exposures that were not finished."""
    scores = [name for name, basis in scored.bases.items() if basis != "measured"]
    asked = scored.table[scores].notna().any(axis=1)
    return int(scored.table.loc[asked, "early"].sum())


def _frames(study: StudyData) -> ShownFrames | None:
    frames = sum(whole_or_none(t.get("frames")) or 0 for t in study.trials)
    dropped = sum(whole_or_none(t.get("dropped")) or 0 for t in study.trials)
    if not frames:
        return None
    trust = sorted({each.timing_trust for each in study.manifests} - {""})
    return ShownFrames(frames, dropped, tuple(trust), _seen(study))


def _seen(study: StudyData) -> dict[str, float]:
    """Sum the seconds in each state of seen time, over trials that recorded it."""
    said = [trial for trial in study.trials if trial.get("live_s")]
    names = recorded_states(study) if said else ()
    return {name: sum(float(trial[name] or 0) for trial in said) for name in names}


def _never_asked(study: StudyData, plan: Plan) -> list[Unscored]:
    """Return completed exposures after which a question was due, and nothing was answered."""
    answered = {
        (s.participant, s.session, s.trial)
        for s in study.sheets
        if s.timepoint == plan.exposure_timepoint
    }
    asking = _asking_sessions(study, plan)
    return [
        Unscored(
            trial["participant"],
            f"session {trial['session']}, exposure {trial['trial']}, "
            f"{trial['condition']}, {plan.exposure_timepoint}",
            "no question was answered after this exposure",
            f"sub-{trial['participant']}/ses-{trial['session']}/questionnaires.csv",
        )
        for trial in study.trials
        if trial["status"] == "completed"
        and (trial["participant"], trial["session"]) in asking
        and (trial["participant"], trial["session"], trial["trial"]) not in answered
    ]


def _asking_sessions(study: StudyData, plan: Plan) -> set[tuple[str, str]]:
    """Return (participant, session) of protocols that ask after each exposure."""
    known = known_outcomes(study.instruments.values())
    asked_first = next((known[name] for name in plan.outcomes if name in known), None)
    if asked_first is None:
        return set()
    return {
        (manifest.participant, str(manifest.session))
        for manifest in study.manifests
        if asks_after_exposures(manifest, plan, asked_first.instrument)
    }


def _ratings(study: StudyData) -> AskedRatings | None:
    if not study.ratings:
        return None
    asked = sum(each.response.size for each in study.ratings)
    return AskedRatings(asked, sum(each.missed for each in study.ratings))


def _sessions(study: StudyData) -> dict[str, int]:
    return dict(sorted(Counter[str](each.status for each in study.manifests).items()))


def _protocol_versions(study: StudyData) -> int:
    """Count the texts of the protocol under which sessions were recorded."""
    return len({manifest.protocol.sha256 for manifest in study.manifests})


def _clamps(study: StudyData) -> tuple[StimulusClamp, ...]:
    """Every clamp that touched a stimulus, with the number of sessions that had it."""
    counts = Counter(clamp for each in study.manifests for clamp in each.clamps)
    return tuple(StimulusClamp(text, n) for text, n in sorted(counts.items()))
