"""Who left, when, under what, and who is not in the analysis for which reason."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vrcomfort.report.ordering import natural
from vrcomfort.stats.withdrawal import fisher_exact

if TYPE_CHECKING:
    from collections.abc import Callable

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.study_data import StudyData

ENDED = {"withdrawn": "withdrew", "stopped": "stop rule"}
BETWEEN = "between exposures"


@dataclass(frozen=True)
class Withdrawal:
    """One participant's last moment."""

    participant: str
    session: str
    position: str
    condition: str
    """Blank if it happened between exposures."""
    scene: str
    after_s: float | None
    """Into the exposure."""
    how: str


def find_withdrawals(study: StudyData) -> list[Withdrawal]:
    """Return the withdrawals that trials.csv and participants.csv record, one per participant."""
    found = {t["participant"]: _from_trial(t) for t in _trials(study) if t["status"] in ENDED}
    last = {t["participant"]: t for t in _trials(study)}
    for person in study.participants:
        name = person["participant"]
        if person["status"] == "withdrawn" and name not in found:
            trial = last.get(name, {})
            found[name] = Withdrawal(
                name, trial.get("session", ""), trial.get("trial", ""), "", "", None, BETWEEN
            )
    return [found[name] for name in sorted(found, key=natural)]


def _trials(study: StudyData) -> list[dict[str, str]]:
    def moment(trial: dict[str, str]) -> tuple[Any, ...]:
        return natural(trial["participant"]), natural(trial["session"]), natural(trial["trial"])

    return sorted(study.trials, key=moment)


def _from_trial(trial: dict[str, str]) -> Withdrawal:
    return Withdrawal(
        participant=trial["participant"],
        session=trial["session"],
        position=trial["trial"],
        condition=trial["condition"],
        scene=trial["scene"],
        after_s=_seconds(trial),
        how=ENDED[trial["status"]],
    )


def _seconds(trial: dict[str, str]) -> float | None:
    try:
        return float(trial["end_s"]) - float(trial["start_s"])
    except (KeyError, ValueError):
        return None


def count_withdrawals(study: StudyData, found: list[Withdrawal]) -> dict[str, Any]:
    """Count by condition, scene, position and by the condition that was met first."""
    first = first_conditions(study)
    return {
        "recorded": bool(study.trials or study.participants),
        "n": len(found),
        "list": [vars(each) for each in found],
        "by_condition": _by(study, found, lambda t: t["condition"]),
        "by_scene": _by(study, found, lambda t: t["scene"]),
        "by_position": _by(study, found, lambda t: f"session {t['session']}, {t['trial']}"),
        "by_first_condition": _by_first(first, {each.participant for each in found}),
    }


def _by(
    study: StudyData, found: list[Withdrawal], key: Callable[[dict[str, str]], str]
) -> list[dict[str, Any]]:
    """Exposures started and ended by a withdrawal, per value of `key`."""
    started = Counter(key(trial) for trial in study.trials)
    ended = Counter(key(t) for t in study.trials if t["status"] in ENDED)
    rows = [
        {"level": level, "exposures": started[level], "withdrawals": ended[level]}
        for level in sorted(started, key=natural)
    ]
    between = sum(not each.condition for each in found)
    extra = {"level": BETWEEN, "exposures": None, "withdrawals": between}
    return [*rows, extra] if between else rows


def first_conditions(study: StudyData) -> dict[str, str]:
    """Return the condition of each participant's first exposure, as far as trials.csv says."""
    first: dict[str, str] = {}
    for trial in _trials(study):
        first.setdefault(trial["participant"], trial["condition"])
    return first


def _by_first(first: dict[str, str], gone: set[str]) -> dict[str, Any]:
    groups = sorted(set(first.values()), key=natural)
    rows = []
    for group in groups:
        members = [name for name, condition in first.items() if condition == group]
        left = sum(name in gone for name in members)
        rows.append({"level": group, "participants": len(members), "withdrawals": left})
    counts = [[r["withdrawals"], r["participants"] - r["withdrawals"]] for r in rows]
    p = fisher_exact(counts) if len(rows) == 2 and gone else None
    return {"rows": rows, "fisher_p": p}


def lost_signs(found: list[Withdrawal], a: str, b: str) -> dict[str, int]:
    """Return for each who withdrew: 1 under condition a, −1 under b, 0 if neither is known."""
    return {each.participant: {a: 1, b: -1}.get(each.condition, 0) for each in found}


def everybody(study: StudyData) -> list[str]:
    """Return every participant that any file names."""
    names = {s.participant for s in study.sheets} | {p["participant"] for p in study.participants}
    return sorted(names, key=natural)


def left_out(
    study: StudyData, scored: Exposures, found: list[Withdrawal], analysed: list[str]
) -> list[dict[str, str]]:
    """Return everybody who is not in the primary analysis, with all known reasons."""
    reasons: dict[str, list[str]] = defaultdict(list)
    for each in found:
        under = f" under {each.condition}" if each.condition else ""
        session = f" in session {each.session}" if each.session else ""
        reasons[each.participant].append(f"{each.how}{under}{session}")
    for person in study.participants:
        if person["status"] == "excluded":
            note = person.get("note") or "no reason noted"
            reasons[person["participant"]].append(f"excluded by the experimenter ({note})")
    for row in scored.excluded:
        reasons[row["participant"]].append(f"{row['questionnaire']}: {row['reason']}")
    default = ["not every exposure has a questionnaire"]
    return [
        {"participant": name, "reason": "; ".join(reasons.get(name) or default)}
        for name in everybody(study)
        if name not in analysed
    ]


def sequences(
    study: StudyData, analysed: list[str], found: list[Withdrawal]
) -> list[dict[str, Any]]:
    """Count participants, withdrawals and analysed per sequence."""
    sequence = {s.participant: s.sequence for s in study.sheets if s.sequence}
    sequence |= {p["participant"]: p["sequence"] for p in study.participants if p["sequence"]}
    gone = {each.participant for each in found}
    return [
        {
            "sequence": name,
            "participants": sum(each == name for each in sequence.values()),
            "withdrew": sum(sequence.get(p) == name for p in gone),
            "analysed": sum(sequence.get(p) == name for p in analysed),
        }
        for name in sorted(set(sequence.values()), key=natural)
    ]
