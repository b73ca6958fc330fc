"""Makes sure that a participant can be run, and which sessions: new, or interrupted ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

from vrcomfort.design import Design, build_design
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, Sequence
from vrcomfort.records import (
    Interrupted,
    access_of,
    enrolled,
    entered,
    note_end,
    only_run,
    opened_study,
    overwriting,
    read_manifest,
    recorded_sessions,
    repair_session,
    session_folder,
    unfinished_sessions,
)
from vrcomfort.records.consents import Given, required_consent
from vrcomfort.records.session_rows import ConsentRow
from vrcomfort.respondent import Respondent, SimulatedRespondent


class Chosen(NamedTuple):
    """Sessions to run, and those among them that were interrupted."""

    numbers: list[int]
    unfinished: list[int]


def choose_sessions(
    study: Path, participant: str, total: int, wanted: Iterable[int] | None, resume: bool
) -> Chosen:
    """Return the sessions that are asked for, or all that are left.

    Raises
    ------
    InputError
        If there is nothing to run, or an interrupted session and no wish to resume, or the
        reverse.
    """
    unfinished = unfinished_sessions(study, participant)
    done = set(recorded_sessions(study, participant)) - set(unfinished)
    left = [number for number in range(1, total + 1) if number not in done]
    if wanted is None and not left:
        which = f"all {total} sessions" if total > 1 else "the only session"
        have = "are" if total > 1 else "is"
        raise InputError(f"{which} of {participant} {have} recorded", file=study)
    numbers = left if wanted is None else _checked(wanted, total, left)
    taken_up = [number for number in numbers if number in unfinished]
    if taken_up and not resume:
        message = f"session {taken_up[0]} of {participant} was interrupted"
        raise InputError(
            f"{message}; continue it with run --resume",
            file=session_folder(study, participant, taken_up[0]),
        )
    if resume and not taken_up:
        raise InputError(f"no session of {participant} was interrupted; leave --resume out")
    for number in done.intersection(numbers):
        raise overwriting(session_folder(study, participant, number), participant, number)
    return Chosen(numbers, taken_up)


def require_rest(protocol: Protocol, study: Path, participant: str, chosen: Chosen) -> None:
    """Raise `InputError` where a new session would follow the one before too soon.

    An interrupted one may go on at any time. Clocks that were set back count as no time.
    """
    new = [number for number in chosen.numbers if number not in chosen.unfinished]
    before = [n for n in recorded_sessions(study, participant) if new and n < new[0]]
    wanted = timedelta(hours=protocol.hours_between_sessions)
    if not before or not wanted:
        return
    ended_at = read_manifest(session_folder(study, participant, before[-1])).get("finished_at")
    if ended_at is None:
        return
    ended = datetime.fromisoformat(ended_at)
    passed = max(datetime.now(UTC) - ended, timedelta())
    if passed < wanted:
        hours = f"{passed / timedelta(hours=1):.1f} h ago, and the protocol wants"
        message = (
            f"session {before[-1]} of {participant} ended {hours} {wanted / timedelta(hours=1):g} h"
        )
        until = (ended + wanted).astimezone().strftime("%Y-%m-%d %H:%M")
        raise InputError(f"{message} between sessions; come back after {until}")


def _changed_media(manifest: Mapping[str, Any], protocol: Protocol) -> str | None:
    """Return a changed picture or sound, if the language is the same."""
    then = manifest["protocol"].get("media") or {}
    if manifest.get("language") != protocol.language:
        return None
    return next((name for name, sha256 in protocol.media.items() if then.get(name) != sha256), None)


def _checked(wanted: Iterable[int], total: int, left: list[int]) -> list[int]:
    numbers = sorted(set(wanted))
    if not numbers:
        raise InputError("no session is asked for; leave the choice out to run all that are left")
    for number in numbers:
        if not 1 <= number <= total:
            none_left = "" if left else ", and none is left to run"
            raise InputError(f"there is no session {number}; this protocol has {total}{none_left}")
    return numbers


class InterruptedSessions:
    """The records of a participant's interrupted sessions."""

    def __init__(self, study: Path, participant: str, numbers: Iterable[int]) -> None:
        self._study = study
        self._folders = {n: session_folder(study, participant, n) for n in numbers}
        self._manifests = {n: read_manifest(folder) for n, folder in self._folders.items()}

    def check(self, protocol: Protocol, *, seed: int, sequence: str, respondent: str) -> None:
        """Raise `InputError` where protocol, seed, order, respondent or language have changed."""
        for number, manifest in self._manifests.items():
            if manifest["protocol"]["sha256"] != protocol.sha256:
                what = "with another text of this protocol; resume it with the same"
            elif (changed := _changed_media(manifest, protocol)) is not None:
                what = f"with another {changed}; resume it with the same"
            elif manifest["seed"] != seed:
                what = f"with seed {manifest['seed']}; resume it with --seed {manifest['seed']}"
            elif manifest["sequence"] != sequence:
                what = f"in sequence {manifest['sequence']}, not {sequence}"
            elif manifest["respondent"] != respondent:
                then = f"--respondent {manifest['respondent']}"
                what = f"with {then}, not {respondent}; resume it with {then}"
            elif manifest.get("language") != protocol.language:
                begun_in = manifest.get("language")
                then = f"--language {begun_in}" if begun_in else "no --language"
                what = f"with {then}; resume it with the same"
            else:
                continue
            raise InputError(f"session {number} was begun {what}", file=self._folders[number])

    def exposure_s(self, wanted_s: float | None) -> float | None:
        """Return the exposure that was overridden before; another may not be asked for now.

        Raises
        ------
        InputError
            If one is.
        """
        for manifest in self._manifests.values():
            shown_s: Any = manifest["exposure_s"]
            if wanted_s not in {None, shown_s}:
                raise InputError(f"this session was begun with exposures of {shown_s:g} s; keep it")
            wanted_s = shown_s
        return wanted_s

    def check_memory(self, respondent: Respondent) -> None:
        """Raise `InputError` where a respondent cannot be put into the state on record."""
        if not isinstance(respondent, SimulatedRespondent):
            return
        for number, manifest in self._manifests.items():
            try:
                if (memory := manifest.get("memory")) is not None:
                    respondent.recall(memory)
            except InputError as error:
                raise error.in_file(self._folders[number] / "manifest.json") from error

    def repair_session(self, sequence: Sequence) -> dict[int, Interrupted]:
        """Mend the files; return session → how far it came."""
        access = access_of(self._study)
        return {
            number: repair_session(folder, sequence.sessions[number - 1], access)
            for number, folder in self._folders.items()
        }


@dataclass(frozen=True, kw_only=True)
class OpenEnrolment:
    """A participant locked for this program; see `open_enrolment`.

    Parameters
    ----------
    exposure_s
        How long an exposure is shown: the protocol's time, or less.
    numbers
        Of the sessions to run.
    interrupted
        What is recorded of those among them that go on.
    covariates
        Of the participant, as the protocol declares them; checked.
    consent
        What is to be entered before the first of the sessions; None where nothing is.
    """

    protocol: Protocol
    participant: str
    study: Path
    design: Design
    exposure_s: float
    numbers: list[int]
    interrupted: InterruptedSessions
    covariates: Mapping[str, str] = field(default_factory=dict)
    consent: ConsentRow | None = None


@contextmanager
def open_enrolment(
    protocol: Protocol,
    participant: str,
    *,
    study: Path,
    respondent: str,
    seed: int | None = None,
    sessions: Iterable[int] | None = None,
    exposure_s: float | None = None,
    resume: bool = False,
    group_readable: bool = False,
    covariates: Mapping[str, str] | None = None,
    consent: Given | None = None,
) -> Iterator[OpenEnrolment]:
    """Make sure that a participant can be run, and keep every other program from it.

    Nothing is recorded yet, nobody enrolled, no headset needed: what is refused, is refused here.

    Parameters
    ----------
    respondent
        Name of the kind that will answer; one session is answered by one kind.
    seed
        Of the study: decides shuffled and random orders. `None` is the study's own (0 in a new
        one). Recorded.
    sessions
        Which; default: all that are left.
    exposure_s
        Shortens the protocol's exposure (and training alike), for demonstrations; the
        respondent's time is stretched back to the protocol's. Recorded.
    resume
        Continue a session that was interrupted: at the first exposure after the last completed
        one, after a new baseline, with the settings and the random state of before.
    group_readable
        A new study's files are for the owner's group as well; see `open_study`.
    covariates
        What the protocol wants to know of everybody who is enrolled.
    consent
        What the participant has given; simulated ones consent to anything.

    Raises
    ------
    InputError
        If the participant or session cannot be run: another program runs them, a session is
        unfinished or on disk, the folder holds another study; or if exposures would be longer
        than the protocol's.
    """
    protocol.shown_s(exposure_s)  # refused before anything is made
    with (
        opened_study(study, protocol, seed=seed, group_readable=group_readable) as kept_seed,
        only_run(study, participant),
    ):
        design = build_design(protocol, seed=kept_seed)
        note_end(study, participant, design.sessions)
        row = enrolled(study, participant)
        known = entered(design, row, covariates or {})
        simulated = respondent == "simulated"
        agreed = required_consent(protocol, study, participant, consent, simulated=simulated)
        chosen = choose_sessions(study, participant, design.sessions, sessions, resume)
        if not simulated:
            require_rest(protocol, study, participant, chosen)
        interrupted = InterruptedSessions(study, participant, chosen.unfinished)
        sequence = row.sequence if row else ""
        interrupted.check(protocol, seed=kept_seed, sequence=sequence, respondent=respondent)
        yield OpenEnrolment(
            protocol=protocol,
            participant=participant,
            study=study,
            design=design,
            exposure_s=protocol.shown_s(interrupted.exposure_s(exposure_s)),
            numbers=chosen.numbers,
            interrupted=interrupted,
            covariates=known,
            consent=agreed,
        )
