"""Makes sure that a participant can be run, before anything else is made ready for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.design import Design, build_design
from vrcomfort.protocol import Protocol
from vrcomfort.records import enrolled, entered, note_end, only_run, open_study
from vrcomfort.records.consents import ConsentRow, Given, required_consent
from vrcomfort.session.resume import InterruptedSessions, choose_sessions, require_rest


@dataclass(frozen=True, kw_only=True)
class Enrolment:
    """A participant whose sessions nobody else can run meanwhile; see `open_enrolment`.

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
    numbers: Sequence[int]
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
) -> Iterator[Enrolment]:
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
    kept_seed = open_study(study, protocol, seed=seed, group_readable=group_readable)
    with only_run(study, participant):
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
        yield Enrolment(
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
