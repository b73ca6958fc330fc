"""What `run` and `simulate` share: a study's folder, what draws its scenes, and who answers."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.cli.playback import PlaybackSetup
from vrcomfort.cli.renderer import describe_machine, make_renderer
from vrcomfort.cli.terminal import dialogue, warn
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, with_task_code
from vrcomfort.protocol.load import missing_wording

if TYPE_CHECKING:
    from vrcomfort.cli.headset_setup import HeadsetSetup
    from vrcomfort.cli.session_devices import ConsoleSetup
    from vrcomfort.records import Durability, Machine
    from vrcomfort.records.consents import Given
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent import Respondent
    from vrcomfort.scene.data import Scene
    from vrcomfort.session import OpenEnrolment, RunOutcome, SessionSettings
    from vrcomfort.session.interfaces import HeadsetFor, Renderer


class RespondentKind(StrEnum):
    """Who answers."""

    SIMULATED = "simulated"
    TERMINAL = "terminal"
    PANEL = "panel"
    CONSOLE = "console"


class StudySetup:
    """One study's protocol, folder, headset and renderer; scenes are loaded once.

    Parameters
    ----------
    playback
        Where there is no live headset.
    frames
        False: time jumps from one event to the next, and nothing is drawn.
    group_readable, durability
        See `session.open_enrolment` and `session.SessionSettings`.

    Raises
    ------
    InputError
        If exposures would be longer than the protocol's, or the file of an own task, which is run
        here, cannot be.
    """

    def __init__(
        self,
        protocol: Protocol,
        study: Path,
        playback: PlaybackSetup,
        seed: int | None,
        exposure_s: float | None,
        *,
        group_readable: bool = False,
        durability: Durability = "each_row",
        frames: bool = True,
    ) -> None:
        self._study = study
        self._playback = playback
        self._seed = seed
        protocol.shown_s(exposure_s)  # refuses a longer one before anything is made
        self._exposure_s = exposure_s
        _require_places(protocol)
        _require_instructions(protocol)
        self._protocol = with_task_code(protocol)
        for file, sha256 in self._protocol.task_code.items():
            warn(f"the code of the task file {file} is run (SHA-256 {sha256})")
        self._group_readable = group_readable
        self._durability = durability
        self._frames = frames
        self._rendering: tuple[StereoRenderer, Machine] | None = None
        self._load_scene = lru_cache(maxsize=None)(_load_scene)

    def open_enrolment(
        self,
        participant: str,
        sessions: list[int] | None,
        kind: RespondentKind,
        *,
        resume: bool = False,
        covariates: Mapping[str, str] | None = None,
        consent: Given | None = None,
    ) -> AbstractContextManager[OpenEnrolment]:
        """Return a participant who can be run; see `session.open_enrolment`.

        Raises
        ------
        InputError
            If a person would be asked a question that has no wording.
        """
        from vrcomfort.session import open_enrolment

        if kind is not RespondentKind.SIMULATED:
            for fault in missing_wording(self._protocol):
                raise fault
        return open_enrolment(
            self._protocol,
            participant,
            study=self._study,
            respondent=kind,
            seed=self._seed,
            sessions=sessions,
            exposure_s=self._exposure_s,
            resume=resume,
            group_readable=self._group_readable,
            covariates=covariates,
            consent=consent,
        )

    def settings(
        self,
        enrolment: OpenEnrolment,
        kind: RespondentKind,
        headset: HeadsetSetup | None = None,
        console: ConsoleSetup | None = None,
    ) -> SessionSettings:
        """Return the settings of sessions in a headset, or without one on the playback."""
        from vrcomfort import session
        from vrcomfort.headset.sound import NobodyHears
        from vrcomfort.operator_interface import NoOperator
        from vrcomfort.session.operator_control import OperatorControl

        respondent = self._respondent(kind, enrolment, headset, console)
        renderer, machine = (headset.renderer, headset.machine) if headset else self._windowless()
        simulated = kind is RespondentKind.SIMULATED
        loader = self._load_scene if self._frames else session.scenes_for(self._protocol)
        return session.SessionSettings(
            respondent=respondent,
            headset_for=headset.headset_for if headset else self._headset_for(),
            load_scene=loader,
            renderer=renderer,
            clock=session.VirtualClock() if simulated else session.WallClock(),
            machine=machine,
            screen=headset.screen if headset else None,
            watchdog=headset.watchdog if headset else None,
            operators=console.operators if console else OperatorControl(NoOperator()),
            durability=self._durability,
            speaker=NobodyHears() if simulated else None,
            jumps=not self._frames,
        )

    def _headset_for(self) -> HeadsetFor:
        """Return what stands in each scene where there is no live headset."""
        from vrcomfort.session import StillHeadset

        return self._playback if self._frames else lambda _name, _scene: StillHeadset()

    def _windowless(self) -> tuple[Renderer, Machine]:
        if not self._frames:
            from vrcomfort.records import Machine
            from vrcomfort.session import NoPictures

            return NoPictures(), Machine()
        if self._rendering is None:
            from vrcomfort.render.display import HASH_EVERY

            renderer = make_renderer(
                self._playback.size_px,
                hash_every=HASH_EVERY,
                photodiode=self._protocol.photodiode,
                finds_hits=True,
            )
            self._rendering = renderer, describe_machine(renderer, self._protocol)
        return self._rendering

    def _respondent(
        self,
        kind: RespondentKind,
        enrolment: OpenEnrolment,
        headset: HeadsetSetup | None,
        console: ConsoleSetup | None,
    ) -> Respondent:
        from vrcomfort.respondent import SimulatedRespondent, TerminalRespondent

        if kind is RespondentKind.SIMULATED:
            settings, seed = self._protocol.simulation, enrolment.design.seed
            return SimulatedRespondent(settings, participant=enrolment.participant, seed=seed)
        if kind is RespondentKind.TERMINAL:
            return TerminalRespondent(dialogue())
        if console is not None and kind is RespondentKind.CONSOLE:
            screen = headset.screen if headset else None
            return console.respondent(screen, self._protocol.words)
        if headset is None:
            raise InputError("--respondent panel needs a headset to answer in")
        return headset.panel


def _require_places(protocol: Protocol) -> None:
    """Raise `InputError` where a view names a place that its scene does not have."""
    from vrcomfort.session.start_pose import place_faults

    for fault in place_faults(protocol):
        raise fault


def _require_instructions(protocol: Protocol) -> None:
    """Raise `InputError` where a file of an instruction cannot be used, or does not fit."""
    if protocol.instructions:
        from vrcomfort.session.instructor import instruction_faults

        for fault in instruction_faults(protocol):
            raise fault


def require_wording(protocol: Protocol, kind: RespondentKind, *, in_headset: bool) -> None:
    """Refuse words that the panel cannot draw, in the participant's language.

    Parameters
    ----------
    in_headset
        A panel is there, whoever answers.

    Raises
    ------
    InputError
        Names the first of them, and what to do.
    """
    from vrcomfort.session.panel_wording import undrawable_wording

    aloud = kind in {RespondentKind.TERMINAL, RespondentKind.CONSOLE}
    if in_headset or not aloud:
        for fault in undrawable_wording(protocol, asked_aloud=aloud):
            raise fault


def _load_scene(source: str) -> Scene:
    from vrcomfort.scene.load import load_scene

    scene = load_scene(source)
    for warning in scene.warnings:
        warn(warning)
    return scene


def outcome_sentence(outcome: RunOutcome, out: Path) -> str:
    """Say what became of a participant's sessions."""
    sessions = ", ".join(map(str, outcome.sessions))
    note = f" ({outcome.note})" if outcome.note else ""
    return (
        f"{outcome.participant} ({outcome.sequence}): session {sessions} recorded, "
        f"{outcome.status}{note}; {out / f'sub-{outcome.participant}'}"
    )
