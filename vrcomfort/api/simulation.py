"""Simulated participants go through all their sessions of a protocol."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.api.outputs import Note, Progress, as_warning, no_progress
from vrcomfort.api.playback import PlaybackSetup, open_trace, require_recorded_gaze
from vrcomfort.api.study_setup import RespondentKind, StudySetup
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.api.study_setup import AskForCode
    from vrcomfort.records.reader import Study
    from vrcomfort.session import RunOutcome
    from vrcomfort.traces.trace import Trace


def simulate_study(
    protocol: Protocol | str | Path,
    out: str | Path,
    *,
    participants: int,
    seed: int | None = None,
    frames: bool = False,
    exposure_s: float | None = None,
    size_px: tuple[int, int] = (320, 400),
    refresh_hz: float | None = None,
    trace: str | Path | None = None,
    language: str | None = None,
    trust: str | None = None,
) -> Study:
    """Simulate participants P01, P02, … of a study and record them as `vrcomfort simulate` does.

    Where a call was stopped, the same call goes on: recorded sessions stay, and an interrupted one
    continues at its next exposure.

    Parameters
    ----------
    protocol : Protocol, str or Path
        A protocol, its file, or the name of a shipped one.
    out : str or Path
        The study folder; made if it is not there.
    participants : int
        How many participants the study has in the end.
    seed : int, optional
        Every random choice derives from it. A study keeps its first one (else 0).
    frames : bool
        Draw every frame, which needs OpenGL. Without, time jumps from one event to the next:
        answers, ratings and withdrawals as with frames, in no time.
    exposure_s : float, optional
        Shorten every exposure to this, in seconds.
    size_px : tuple of int
        (width, height) of one eye's image, with `frames`.
    refresh_hz : float, optional
        Display rate with `frames`; the trace's own without it.
    trace : str or Path, optional
        Head trace (CSV) with `frames`; the walk shipped with each scene without it.
    language : str, optional
        One of the protocol's languages; its first without it.
    trust : str, optional
        Consent to run the protocol's own Python files of this hash; it is kept.

    Returns
    -------
    Study
        The recorded study; see `vrcomfort.read_study`.

    Raises
    ------
    InputError
        If no participant is left, nobody has consented to the protocol's Python files (the hash to
        trust is named), a person was in a session, one was begun with other settings,
        or the folder holds another study.

    Examples
    --------
    >>> import vrcomfort
    >>> study = vrcomfort.simulate_study("smoke", "pilot", participants=4)  # doctest: +SKIP
    """
    from vrcomfort.records.reader import Study

    if not isinstance(protocol, Protocol):
        protocol = load_protocol(protocol)
    outcomes = simulate_sessions(
        protocol.spoken(language),
        participants=participants,
        out=Path(out),
        seed=seed,
        size_px=size_px,
        trace=open_trace(Path(trace)) if trace else None,
        refresh_hz=refresh_hz,
        exposure_s=exposure_s,
        frames=frames,
        trust=trust,
    )
    finish(outcomes)
    return Study(out)


def finish(outcomes: list[RunOutcome]) -> None:
    """Raise where sessions were stopped, or something of them could not be recorded.

    Raises
    ------
    KeyboardInterrupt
        If the last session was aborted; it has heard the signal and closed its files.
    InputError
        If something was lost.
    """
    if outcomes[-1].status == "aborted":
        raise KeyboardInterrupt
    if lost := [sentence for outcome in outcomes for sentence in outcome.lost]:
        raise InputError("; ".join(lost))


def simulate_sessions(
    protocol: Protocol,
    *,
    participants: int,
    out: Path,
    seed: int | None = None,
    size_px: tuple[int, int],
    trace: Trace | None = None,
    refresh_hz: float | None = None,
    exposure_s: float | None = None,
    group_readable: bool = False,
    frames: bool = True,
    trust: str | None = None,
    ask: AskForCode | None = None,
    note: Note = as_warning,
    progress: Progress = no_progress,
) -> list[RunOutcome]:
    """Run all sessions of simulated participants P01, P02, … that are left.

    Stops where one is aborted. An interrupted session is continued.

    Raises
    ------
    InputError
        As `simulate_study`.
    """
    from vrcomfort.design import build_design
    from vrcomfort.records import mixed_kinds_notice, opened_study

    if not frames and (trace or refresh_hz):
        raise InputError("--no-draw plays no head trace; leave --trace and --refresh-hz out")
    if frames and protocol.simulation.eyes is None:
        require_recorded_gaze(protocol.conditions, trace)
    playback = PlaybackSetup(size_px, protocol.headset.ipd_m, trace, refresh_hz)
    setup = StudySetup(
        protocol,
        out,
        playback,
        seed,
        exposure_s,
        durability="session_end",  # a power cut costs a session that can be simulated again
        frames=frames,
        trust=trust,
        ask=ask,
        note=note,
    )
    resume_check = ResumeCheck(protocol, playback if frames else None, exposure_s)
    with opened_study(out, protocol, seed=seed, group_readable=group_readable) as kept_seed:
        design = build_design(protocol, seed=kept_seed)
        outcomes: list[RunOutcome] = []
        ends = {name: resume_check.ends(out, name) for name in _names(out, participants)}
        if told := mixed_kinds_notice(out, simulated=True):
            note(told)
        if protocol.ratings and protocol.shown_s(exposure_s) < protocol.longest_s:
            note(
                f"exposures of {protocol.longest_s:g} s are shortened to {exposure_s:g} s, and "
                "their ratings come at shortened times, or are missed between frames; --no-draw "
                "without --exposure-s has them at the protocol's times"
            )
        with progress("simulated", participants, unit="participants") as advance:
            for number, (name, ended) in enumerate(ends.items(), start=1):
                if not _is_over(out, name, ended, design.sessions):
                    outcomes.append(
                        _simulate_one(setup, out, name, design.simulated_covariates(number))
                    )
                advance()
                if outcomes and outcomes[-1].status == "aborted":
                    break
    if not outcomes:
        message = f"all sessions of all {participants} participants are recorded"
        raise InputError(f"{message}; choose another output folder, or more participants", file=out)
    return outcomes


def _names(study: Path, participants: int) -> list[str]:
    """Return P01, P02, …, with as many digits as the study has already."""
    from vrcomfort.records import read_participants

    there = [row.participant for row in read_participants(study)]
    digits = len(there[0]) - 1 if there else max(2, len(str(participants)))
    return [f"P{number:0{digits}d}" for number in range(1, participants + 1)]


def _simulate_one(
    setup: StudySetup, study: Path, name: str, covariates: dict[str, str]
) -> RunOutcome:
    from vrcomfort import session
    from vrcomfort.records import unfinished_sessions

    kind, resume = RespondentKind.SIMULATED, bool(unfinished_sessions(study, name))
    with setup.open_enrolment(name, None, kind, resume=resume, covariates=covariates) as enrolment:
        return session.run(enrolment, setup.settings(enrolment))


def _is_over(study: Path, name: str, ended: list[str], sessions: int) -> bool:
    """Return whether a participant has nothing left to simulate, and see that the study says so."""
    from vrcomfort.records import note_end, read_participants

    note_end(study, name, sessions)
    known = {row.participant: row.status for row in read_participants(study)}.get(name)
    over = ended.count("completed") + ended.count("ended") == sessions
    return over or known in {"withdrawn", "excluded"}


NO_HEADSET = "none"
"""The headset of a session without frames, as its manifest names it."""
REMEDY = "go on with the same, or choose another output folder"


class ResumeCheck:
    """Settings that decide a simulated session's outcome, beside its participant and its seed.

    Parameters
    ----------
    playback
        None without frames.
    exposure_s
        As asked for; `None` is the protocol's.
    """

    def __init__(
        self, protocol: Protocol, playback: PlaybackSetup | None, exposure_s: float | None
    ) -> None:
        self._protocol = protocol
        self._playback = playback
        self._exposure_s = protocol.shown_s(exposure_s)

    def ends(self, study: Path, name: str) -> list[str]:
        """Return how each recorded session of a participant ended.

        Raises
        ------
        InputError
            If a person was in one, or it was begun with something else than this.
        """
        from vrcomfort.records import read_manifest, recorded_sessions, session_folder

        folders = [session_folder(study, name, each) for each in recorded_sessions(study, name)]
        manifests = {folder: read_manifest(folder) for folder in folders}
        for folder, manifest in manifests.items():
            self._check(folder, manifest)
        return [str(manifest.get("status")) for manifest in manifests.values()]

    def _check(self, folder: Path, manifest: Mapping[str, Any]) -> None:
        if (respondent := manifest.get("respondent")) != RespondentKind.SIMULATED:
            message = f"this session was begun with --respondent {respondent}"
            advice = "choose another output folder for simulations"
            raise InputError(f"{message}; {advice}", file=folder)
        try:
            difference = next(self._differences(manifest), None)
        except (KeyError, TypeError, ValueError) as error:
            file = folder / "manifest.json"
            raise InputError("this manifest is damaged; restore it", file=file) from error
        if difference:
            raise InputError(f"this session was begun with {difference}; {REMEDY}", file=folder)

    def _differences(self, manifest: Mapping[str, Any]) -> Iterator[str]:
        """Yield the differences of a recorded session from this one, in words."""
        if manifest["protocol"]["sha256"] != self._protocol.sha256:
            yield "another text of this protocol"
        if (shown_s := manifest["exposure_s"]) != self._exposure_s:
            yield f"exposures of {shown_s:g} s, not {self._exposure_s:g} s"
        if headset := manifest["headset"]:  # a session may end before its first exposure
            yield from self._differences_of(headset)

    def _differences_of(self, headset: Mapping[str, Any]) -> Iterator[str]:
        playback = self._playback
        if (headset["name"] == NO_HEADSET) != (playback is None):
            yield "--no-draw" if playback else "frames"
        if playback is None:
            return
        width, height = headset["image_size_px"]
        if (width, height) != playback.size_px:
            yield f"--size {width}x{height}"
        if headset["refresh_hz"] not in (rates_hz := self._would_be("refresh_hz")):
            yield f"frames at {headset['refresh_hz']:g} Hz, not {rates_hz[0]:g} Hz"
        if headset.get("trace_sha256") not in self._would_be("trace_sha256"):
            yield "another head trace"

    def _would_be(self, fact: str) -> list[Any]:
        return [facts.get(fact) for facts in self._headsets]

    @cached_property
    def _headsets(self) -> list[dict[str, Any]]:
        """Facts of the headset for a manifest, by the scene that comes first."""
        from vrcomfort.session import headset_facts

        playback = self._playback
        if playback is None:
            return []
        scenes = [self._protocol.view(name).scene for name in self._protocol.scenes]
        return [headset_facts(playback.standing_in(scene)) for scene in scenes]
