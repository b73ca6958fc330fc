"""Withdrawals by condition, scene and position, and reasons for missing participants."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.study_data import people_of, trial_s, undone_attempts
from vrcomfort.stats.proportions import fisher_exact

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from vrcomfort.report.exclusions import ExcludedByRule
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.study_data import StudyData

ENDED = {"withdrawn": "withdrew", "stopped": "stop rule"}
AFTER = "after the exposure"
"""Somebody who finished an exposure and left at the questionnaire or before the next one."""


@dataclass(frozen=True)
class Withdrawal:
    """One participant's last moment."""

    participant: str
    session: str
    position: str
    condition: str
    """Of the exposure that it happened in or after; blank before the first of a session."""
    scene: str
    after_s: float | None
    """Time into the exposure; None if it was over."""
    how: str


@dataclass(frozen=True)
class EarlyEnding:
    """How often something ended exposures, sessions or studies before their time."""

    ends: str
    by: str
    n: int


@dataclass(frozen=True)
class LevelWithdrawals:
    """Exposures started, and withdrawals during and after them, of a level."""

    level: str
    exposures: int
    during: int
    after: int


@dataclass(frozen=True)
class FirstConditionWithdrawals:
    """Participants by the condition that they met first, and how many of them withdrew."""

    level: str
    participants: int
    withdrawals: int


@dataclass(frozen=True)
class WithdrawalsByFirst:
    """Withdrawals by first condition, with Fisher's exact test of two conditions."""

    rows: tuple[FirstConditionWithdrawals, ...]
    fisher_p: float | None


@dataclass(frozen=True)
class WithdrawalCounts:
    """The withdrawals of a study; key `withdrawals` of results.json."""

    recorded: bool
    n: int
    list: tuple[Withdrawal, ...]
    early_endings: tuple[EarlyEnding, ...]
    by_condition: tuple[LevelWithdrawals, ...]
    by_scene: tuple[LevelWithdrawals, ...]
    by_position: tuple[LevelWithdrawals, ...]
    by_first_condition: WithdrawalsByFirst


@dataclass(frozen=True)
class MissingParticipant:
    """A participant missing from some or all tests, with the reason."""

    participant: str
    reason: str


@dataclass(frozen=True)
class SequenceCounts:
    """Participants of a planned sequence."""

    sequence: str
    participants: int
    withdrew: int
    analysed: int


def find_withdrawals(study: StudyData) -> list[Withdrawal]:
    """Return the withdrawals that trials.csv and participants.csv record, one per participant.

    Whom the experimenter screened out did not withdraw.
    """
    undone, screened = undone_attempts(study), screened_out(study)
    ended = [
        t
        for t in _trials(study)
        if t["status"] in ENDED and _attempt(t) not in undone and not _comes_back(t)
    ]
    found = {t["participant"]: _from_trial(t) for t in ended}
    last = {t["participant"]: t for t in _trials(study)}
    for person in study.participants:
        name = person["participant"]
        if person["status"] == "withdrawn" and name not in {*found, *screened}:
            found[name] = _after_trial(name, last.get(name, {}))
    return [found[name] for name in sorted(found, key=natural)]


def _comes_back(trial: Mapping[str, str]) -> bool:
    """Return whether a withdrawal ended the session alone, not the study."""
    return trial.get("abort_code", "").endswith("_session")


def screened_out(study: StudyData) -> set[str]:
    """Return the participants screened out by an experimenter."""
    return {
        manifest.participant
        for manifest in study.manifests
        if manifest.status == "withdrawn" and (manifest.ended or {}).get("by") == "screening"
    }


def early_endings(study: StudyData) -> list[EarlyEnding]:
    """Count early endings of exposures, sessions and studies by cause."""
    counts: Counter[tuple[str, str]] = Counter()
    for trial in study.trials:
        if trial["status"] == "completed" and trial.get("abort_code"):
            counts["exposure", trial["abort_code"]] += 1
    for manifest in study.manifests:
        ended = manifest.ended
        if manifest.status in {"ended", "withdrawn"} and ended:
            counts[str(ended.get("ends")), str(ended.get("by"))] += 1
    return [EarlyEnding(ends, by, count) for (ends, by), count in sorted(counts.items())]


def _attempt(trial: dict[str, str]) -> tuple[str, ...]:
    return tuple(trial.get(name, "") for name in ("participant", "session", "trial", "attempt"))


def _trials(study: StudyData) -> list[dict[str, str]]:
    def moment(trial: dict[str, str]) -> tuple[Any, ...]:
        return natural(trial["participant"]), natural(trial["session"]), natural(trial["trial"])

    return sorted(study.trials, key=moment)


def _after_trial(name: str, trial: dict[str, str]) -> Withdrawal:
    return Withdrawal(
        participant=name,
        session=trial.get("session", ""),
        position=trial.get("trial", ""),
        condition=trial.get("condition", ""),
        scene=trial.get("scene", ""),
        after_s=None,
        how=AFTER,
    )


def _from_trial(trial: dict[str, str]) -> Withdrawal:
    return Withdrawal(
        participant=trial["participant"],
        session=trial["session"],
        position=trial["trial"],
        condition=trial["condition"],
        scene=trial["scene"],
        after_s=trial_s(trial),
        how=ENDED[trial["status"]],
    )


def count_withdrawals(study: StudyData, found: Sequence[Withdrawal]) -> WithdrawalCounts:
    """Count by condition, scene, position and by the condition that was met first."""
    first = first_conditions(study)
    return WithdrawalCounts(
        recorded=bool(study.trials or study.participants),
        n=len(found),
        list=tuple(found),
        early_endings=tuple(early_endings(study)),
        by_condition=_by(study, found, lambda t: t["condition"], lambda w: w.condition),
        by_scene=_by(study, found, lambda t: t["scene"], lambda w: w.scene),
        by_position=_by(
            study,
            found,
            lambda t: f"session {t['session']}, exposure {t['trial']}",
            lambda w: f"session {w.session}, exposure {w.position}",
        ),
        by_first_condition=_by_first(first, {each.participant for each in found}),
    )


def _by(
    study: StudyData,
    found: Sequence[Withdrawal],
    of_trial: Callable[[dict[str, str]], str],
    of_withdrawal: Callable[[Withdrawal], str],
) -> tuple[LevelWithdrawals, ...]:
    """Exposures started, and withdrawals during and after them, per level."""
    started = Counter(map(of_trial, study.trials))
    during = Counter(of_withdrawal(w) for w in found if w.how != AFTER)
    after = Counter(of_withdrawal(w) for w in found if w.how == AFTER and w.condition)
    return tuple(
        LevelWithdrawals(level, started[level], during[level], after[level])
        for level in sorted(started, key=natural)
    )


def first_conditions(study: StudyData) -> dict[str, str]:
    """Return the condition of each participant's first exposure, as far as trials.csv says."""
    first: dict[str, str] = {}
    for trial in _trials(study):
        first.setdefault(trial["participant"], trial["condition"])
    return first


def _by_first(first: dict[str, str], gone: set[str]) -> WithdrawalsByFirst:
    groups = sorted(set(first.values()), key=natural)
    left = Counter(condition for name, condition in first.items() if name in gone)
    total = Counter(first.values())
    counts = [[left[group], total[group] - left[group]] for group in groups]
    return WithdrawalsByFirst(
        tuple(FirstConditionWithdrawals(group, total[group], left[group]) for group in groups),
        fisher_exact(counts) if len(groups) == 2 and gone else None,
    )


def lost_signs(found: Sequence[Withdrawal], a: str, b: str) -> dict[str, int]:
    """Return a sign for each withdrawal: 1 under condition a, −1 under b, 0 where unknown."""
    return {each.participant: {a: 1, b: -1}.get(each.condition, 0) for each in found}


def everybody(study: StudyData) -> list[str]:
    """Return every participant that any file names."""
    return sorted(people_of(study), key=natural)


def why_not(
    study: StudyData,
    scored: Exposures,
    found: Sequence[Withdrawal],
    exclusions: Sequence[ExcludedByRule],
    *,
    in_every_test: set[str],
) -> list[MissingParticipant]:
    """Return the participants missing from some or all tests, with all known reasons."""
    reasons: dict[str, list[str]] = defaultdict(list)
    for withdrawal in found:
        reasons[withdrawal.participant].append(_in_words(withdrawal, study.labels))
    for person in study.participants:
        if person["status"] == "withdrawn" and person.get("note"):
            reasons[person["participant"]].append(f"note: {person['note']}")
        if person["status"] == "excluded":
            note = person.get("note") or "no reason noted"
            reasons[person["participant"]].append(f"excluded by the experimenter ({note})")
    for row in exclusions:
        what = "" if row.is_person else f"{row.what}: "
        reasons[row.participant].append(f"{what}rule {row.rule} ({row.reason})")
    for each in scored.excluded:
        what = with_labels(each.questionnaire, study.labels)
        reasons[each.participant].append(f"{what}: {each.reason}")
    asked = "not every exposure has a questionnaire"
    default = [asked if study.sheets else "no value of what was compared"]
    return [
        MissingParticipant(name, "; ".join(reasons.get(name) or default))
        for name in everybody(study)
        if name not in in_every_test
    ]


def with_labels(questionnaire: str, labels: Mapping[str, str]) -> str:
    """Return the name of a questionnaire (see `Sheet.name`) with the label of its condition."""
    return ", ".join(labels.get(part, part) for part in questionnaire.split(", "))


def _in_words(each: Withdrawal, labels: dict[str, str]) -> str:
    if not each.condition:
        return "withdrew before the first exposure"
    label = labels.get(each.condition, each.condition)
    where = f"{label}, session {each.session}, exposure {each.position}"
    return f"withdrew after {where}" if each.how == AFTER else f"{each.how} in {where}"


def _one_sequence_each(study: StudyData) -> dict[str, str]:
    """Return participant → sequence.

    Raises
    ------
    InputError
        If a participant is in two: then two people have one name, or an order was noted wrongly.
    """
    named = [(s.participant, s.sequence, s.place) for s in study.sheets]
    named += [
        (p["participant"], p.get("sequence", ""), "participants.csv") for p in study.participants
    ]
    found: dict[str, tuple[str, str]] = {}
    for who, sequence, place in named:
        if not sequence:
            continue
        before, there = found.setdefault(who, (sequence, place))
        if before != sequence:
            raise InputError(
                f"participant {who} is in sequence `{before}` ({there}) and in `{sequence}` "
                f"({place}); give two people two names, or correct one of them"
            )
    return {who: sequence for who, (sequence, _) in found.items()}


def sequences(
    study: StudyData, analysed: Sequence[str], found: Sequence[Withdrawal]
) -> list[SequenceCounts]:
    """Count participants, withdrawals and analysed per sequence."""
    sequence = _one_sequence_each(study)
    gone = {each.participant for each in found}
    return [
        SequenceCounts(
            name,
            participants=sum(each == name for each in sequence.values()),
            withdrew=sum(sequence.get(p) == name for p in gone),
            analysed=sum(sequence.get(p) == name for p in analysed),
        )
        for name in sorted(set(sequence.values()), key=natural)
    ]
