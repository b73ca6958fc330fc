"""Makes sure that a participant can be run, before anything else is made ready for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from vrcomfort.design import Design, build_design
from vrcomfort.protocol import Protocol
from vrcomfort.records import Machine, enrol, enrolled, only_run, open_study
from vrcomfort.respondent import Respondent
from vrcomfort.session.clock import Clock, VirtualClock
from vrcomfort.session.flow import Lab
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.interfaces import HeadsetFor, LoadScene, ProgressCallback, Renderer
from vrcomfort.session.interfaces import silent as no_progress
from vrcomfort.session.resume import Earlier, choose_sessions
from vrcomfort.session.participant_sessions import Outcome, Work


@contextmanager
def reserve(
    protocol: Protocol,
    participant: str,
    *,
    study: Path,
    respondent: str,
    seed: int | None = None,
    sessions: Iterable[int] | None = None,
    exposure_s: float | None = None,
    resume: bool = False,
) -> Iterator[Reservation]:
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

    Raises
    ------
    InputError
        If the participant or session cannot be run: another program runs them, a session is
        unfinished or on disk, the folder holds another study; or if exposures would be longer
        than the protocol's.
    """
    protocol.shown_s(exposure_s)  # refused before anything is made
    kept_seed = open_study(study, protocol, seed=seed)
    with only_run(study, participant):
        design = build_design(protocol, seed=kept_seed)
        row = enrolled(study, participant)
        chosen = choose_sessions(study, participant, design.sessions, sessions, resume)
        earlier = Earlier(study, participant, chosen.unfinished)
        sequence = row.sequence if row else ""
        earlier.check(protocol, seed=kept_seed, sequence=sequence, respondent=respondent)
        shown_s = protocol.shown_s(earlier.exposure_s(exposure_s))
        yield Reservation(protocol, participant, study, design, shown_s, chosen.numbers, earlier)


@dataclass(frozen=True)
class Reservation:
    """A participant whose sessions nobody else can run meanwhile; see `reserve`."""

    protocol: Protocol
    participant: str
    study: Path
    design: Design
    exposure_s: float
    numbers: Sequence[int]
    earlier: Earlier

    def run(
        self,
        *,
        load_scene: LoadScene,
        headset_for: HeadsetFor,
        renderer: Renderer,
        respondent: Respondent,
        clock: Clock | None = None,
        machine: Machine | None = None,
        screen: PanelScreen | None = None,
        progress: ProgressCallback = no_progress,
    ) -> Outcome:
        """Run the sessions.

        Parameters
        ----------
        clock
            `VirtualClock` (the default) for simulated participants, `WallClock` for people.
        screen
            Where questions are asked in the headset: what happens to it meanwhile is recorded.

        Returns
        -------
        Outcome
            Ctrl-C ends in status "aborted", with everything written and all files closed.

        Raises
        ------
        InputError
            If the disk refuses, or the headset's runtime goes away; what is there stays.
        """
        row = enrol(self.study, self.design, self.participant)
        lab = Lab(
            self.protocol, load_scene, headset_for, renderer, clock or VirtualClock(), progress,
            self.exposure_s,
        )  # fmt: skip
        work = Work(
            self.study, lab, self.participant, self.design.sequence(row.sequence), respondent,
            self.design.seed, machine or Machine(), self.earlier.take_up(), screen,
        )  # fmt: skip
        return work.run(self.numbers)
