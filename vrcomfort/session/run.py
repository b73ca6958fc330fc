"""Takes one participant through their sessions and keeps everything that happened."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.headset.base import Headset
from vrcomfort.protocol import Protocol, Sequence
from vrcomfort.records import (
    Machine,
    Manifest,
    Recorder,
    completed_sessions,
    enrol,
    open_study,
    recorded_sessions,
    set_status,
)
from vrcomfort.records.study import now
from vrcomfort.respondent import Respondent
from vrcomfort.session.clock import Clock, VirtualClock
from vrcomfort.session.diary import Diary
from vrcomfort.session.flow import Lab, SessionFlow, SessionStatus
from vrcomfort.session.parts import HeadsetFor, LoadScene, Progress, ProgressCallback, Renderer
from vrcomfort.session.parts import silent as no_progress


@dataclass(frozen=True)
class Outcome:
    """How far a participant came.

    Parameters
    ----------
    status
        completed (all sessions are on disk), enrolled (more to come), withdrawn or aborted.
    sessions
        Numbers of the sessions that this run recorded, also in part.
    note
        Why it ended early.
    """

    participant: str
    sequence: str
    status: str
    sessions: tuple[int, ...]
    note: str = ""


def run(
    protocol: Protocol,
    participant: str,
    *,
    study: Path,
    load_scene: LoadScene,
    headset_for: HeadsetFor,
    renderer: Renderer,
    respondent: Respondent,
    clock: Clock | None = None,
    seed: int | None = None,
    sessions: Iterable[int] | None = None,
    exposure_s: float | None = None,
    machine: Machine | None = None,
    progress: ProgressCallback = no_progress,
) -> Outcome:
    """Run the sessions of one participant that are not on disk yet, or those asked for.

    Parameters
    ----------
    seed
        Of the study: decides shuffled and random orders. `None` is the study's own (0 in a new
        one). Recorded.
    clock
        `VirtualClock` (the default) for simulated participants, `WallClock` for people.
    exposure_s
        Overrides the protocol's exposure (training is shortened alike), for demonstrations; the
        respondent's time is stretched back to the protocol's. Recorded.

    Returns
    -------
    Outcome
        Ctrl-C ends in status "aborted", with everything written and all files closed.

    Raises
    ------
    InputError
        If the participant or session cannot be run, or the disk refuses; what is there stays.
    """
    if exposure_s is not None and exposure_s <= 0:
        raise InputError(f"an exposure of {exposure_s} s shows nothing; give a positive number")
    kept_seed = open_study(study, protocol, seed=seed)
    design = build_design(protocol, seed=kept_seed)
    row = enrol(study, design, participant)
    sequence = design.sequence(row.sequence)
    lab = Lab(
        protocol, load_scene, headset_for, renderer, clock or VirtualClock(), progress,
        exposure_s or protocol.exposure_s,
    )  # fmt: skip
    work = _Work(study, lab, participant, sequence, respondent, kept_seed, machine or Machine())
    return work.run(_to_run(study, participant, sequence, sessions))


def _to_run(
    study: Path, participant: str, sequence: Sequence, wanted: Iterable[int] | None
) -> list[int]:
    total = len(sequence.sessions)
    if wanted is None:
        done = recorded_sessions(study, participant)
        left = [number for number in range(1, total + 1) if number not in done]
        if not left:
            raise InputError(f"all {total} sessions of {participant} are recorded", file=study)
        return left
    numbers = sorted(set(wanted))
    if not numbers:
        raise InputError("no session is asked for; leave the choice out to run all that are left")
    for number in numbers:
        if not 1 <= number <= total:
            raise InputError(f"there is no session {number}; this protocol has {total}")
    return numbers


@dataclass(frozen=True)
class _Work:
    study: Path
    lab: Lab
    participant: str
    sequence: Sequence
    respondent: Respondent
    seed: int
    machine: Machine

    def run(self, numbers: list[int]) -> Outcome:
        """Run sessions until one is not completed."""
        ran: list[int] = []
        for number in numbers:
            ran.append(number)
            status, note = self._session(number)
            if status != "completed":
                break
        if status == "withdrawn":
            set_status(self.study, self.participant, "withdrawn", f"session {ran[-1]}: {note}")
            return self._outcome(status, ran, note)
        if status == "aborted":
            set_status(self.study, self.participant, "enrolled", f"session {ran[-1]} aborted")
            return self._outcome(status, ran, note)
        complete = completed_sessions(self.study, self.participant)
        all_done = len(complete) == len(self.sequence.sessions)
        status_now = "completed" if all_done else "enrolled"
        set_status(self.study, self.participant, status_now)
        return self._outcome(status_now, ran)

    def _outcome(self, status: str, ran: list[int], note: str = "") -> Outcome:
        return Outcome(self.participant, self.sequence.name, status, tuple(ran), note)

    def _session(self, number: int) -> tuple[SessionStatus, str]:
        self.lab.progress(Progress("session", self.participant, number))
        with Recorder(self.study, self.participant, number) as recorder:
            manifest = self._manifest(number)
            lab = _noting_headset(self.lab, manifest, recorder.folder)
            manifest.write(recorder.folder)
            diary = Diary(self.participant, number, recorder, lab.clock, lab.progress)
            flow = SessionFlow(lab, diary=diary, sequence=self.sequence, respondent=self.respondent)
            status, note = _kept(flow, manifest, recorder.folder)
        self.lab.progress(Progress("end", self.participant, number, text=status))
        return status, note

    def _manifest(self, number: int) -> Manifest:
        return Manifest(
            participant=self.participant,
            session=number,
            sequence=self.sequence.name,
            protocol=self.lab.protocol,
            machine=self.machine,
            headset={},
            respondent=self.respondent.name,
            seed=self.seed,
            exposure_s=self.lab.exposure_s,
            started_at=now(),
            clamps=_limits(self.lab.protocol),
        )


def _noting_headset(lab: Lab, manifest: Manifest, folder: Path) -> Lab:
    """Return the lab with headsets that enter themselves into the manifest when first used."""

    def headset_for(name: str, scene: Any) -> Headset:
        headset = lab.headset_for(name, scene)
        if not manifest.headset:
            manifest.headset = {
                "name": headset.name,
                "refresh_hz": headset.refresh_hz,
                "image_size_px": list(headset.image_size_px),
                "ipd_m": lab.protocol.headset.ipd_m,
            }
            manifest.write(folder)
        return headset

    return replace(lab, headset_for=headset_for)


def _limits(protocol: Protocol) -> list[str]:
    """Return the clamps that the conditions put on the stimulus."""
    limits = []
    for condition in protocol.conditions:
        if blur := condition.depth_of_field:
            radius = f"{blur.max_radius_percent:g} % of one eye's image width"
            limits.append(f"{condition.name}: circle of confusion at most {radius} (radius)")
        if motion := condition.motion_blur:
            streak = f"{motion.max_radius_percent:g} % of one eye's image width"
            limits.append(f"{condition.name}: half a motion streak at most {streak}")
    return limits


def _kept(flow: SessionFlow, manifest: Manifest, folder: Path) -> tuple[SessionStatus, str]:
    """Run a session and write into its manifest how it ended, whatever ended it."""
    status: SessionStatus = "aborted"
    note = ""
    try:
        status, note = flow.run()
    except KeyboardInterrupt:
        note = "stopped by the operator"
    except BaseException:
        with suppress(InputError):  # the first error is the one to tell
            _close(manifest, folder, "aborted")
        raise
    _close(manifest, folder, status)
    return status, note


def _close(manifest: Manifest, folder: Path, status: str) -> None:
    manifest.status, manifest.finished_at = status, now()
    manifest.write(folder)
