"""A study as `run` and `simulate` share it: its folder, its renderer, its respondents."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from typing import Protocol as Shape

from vrcomfort.api.outputs import Note, as_warning
from vrcomfort.api.playback import PlaybackSetup
from vrcomfort.api.rendering import describe_machine, make_renderer
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, task_code_of, with_task_code
from vrcomfort.protocol.load import missing_wording

if TYPE_CHECKING:
    from vrcomfort.geometry import Pose
    from vrcomfort.headset.base import Headset
    from vrcomfort.headset.watchdog import Watchdog
    from vrcomfort.records import Durability, Machine
    from vrcomfort.records.consents import Given
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent import Respondent
    from vrcomfort.scene.data import Scene
    from vrcomfort.scene.floors import Floors
    from vrcomfort.session import OpenEnrolment, RunOutcome, SessionSettings
    from vrcomfort.session.interfaces import HeadsetFor, Renderer
    from vrcomfort.session.operator_control import OperatorControl
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.tasks import TaskCode

    AskForCode = Callable[[TaskCode], bool]

    class LiveHeadset(Headset, Shape):
        """A headset that is worn, or a window on a desktop."""

        def place(self, *, spawn: Pose, floors: Floors | None = None, on_foot: bool = True) -> None:
            """Put the participant on `spawn`."""


class RespondentKind(StrEnum):
    """Respondents that a session can have."""

    SIMULATED = "simulated"
    TERMINAL = "terminal"
    PANEL = "panel"
    CONSOLE = "console"


@dataclass(frozen=True)
class HeadsetSetup:
    """Parts of a session in a headset.

    Parameters
    ----------
    panel, screen
        A respondent who answers in the headset, and where the questions stand.
    watchdog
        Of the headset's runtime, where it has one.
    """

    headset: LiveHeadset
    renderer: StereoRenderer
    panel: Respondent
    screen: PanelScreen
    machine: Machine
    watchdog: Watchdog | None = None

    def headset_for(self, scene_name: str, scene: Any) -> LiveHeadset:
        """Lead the participant to the scene's starting point."""
        from vrcomfort.scene.floors import Floors

        del scene_name
        self.headset.place(spawn=scene.spawn, floors=Floors(scene.walkable), on_foot=scene.on_foot)
        return self.headset


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
    trust
        Hash of the protocol's own Python files, as somebody's consent to run them.
    ask
        Asks for that consent; without it, it is the hash or an earlier one.
    note
        Takes sentences on the scenes and the code of tasks.

    Raises
    ------
    InputError
        If exposures would be longer than the protocol's, nobody has consented to its Python files,
        or one of them, which are run here, cannot be.
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
        trust: str | None = None,
        ask: AskForCode | None = None,
        note: Note = as_warning,
    ) -> None:
        self._study = study
        self._playback = playback
        self._seed = seed
        protocol.shown_s(exposure_s)  # refuses a longer one before anything is made
        self._exposure_s = exposure_s
        _require_places(protocol)
        _require_instructions(protocol)
        code = task_code_of(protocol)
        _require_trust(code, trust, ask)
        self._protocol = with_task_code(protocol, code)
        for file, sha256 in code.hashes.items():
            note(f"the code of the task file {file} is run (SHA-256 {sha256})")
        self._group_readable = group_readable
        self._durability = durability
        self._frames = frames
        self._rendering: tuple[StereoRenderer, Machine] | None = None
        self._load_scene = lru_cache(maxsize=None)(_scene_loader(self._protocol, frames, note))

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
        """Return an open enrolment of a participant; see `session.open_enrolment`.

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
        respondent: Respondent | None = None,
        headset: HeadsetSetup | None = None,
        operators: OperatorControl | None = None,
    ) -> SessionSettings:
        """Return the settings of sessions in a headset, or without one on the playback.

        Parameters
        ----------
        respondent
            A person; without one, a simulated participant answers, faster than the clock.
        operators
            The operator's control; without it there is Ctrl-C alone.
        """
        from vrcomfort import session
        from vrcomfort.headset.sound import SilentSpeaker
        from vrcomfort.operator_interface import NoOperator
        from vrcomfort.session.operator_control import OperatorControl

        renderer, machine = (headset.renderer, headset.machine) if headset else self._windowless()
        simulated = respondent is None
        return session.SessionSettings(
            respondent=respondent or self._simulated(enrolment),
            headset_for=headset.headset_for if headset else self._headset_for(),
            load_scene=self._load_scene,
            renderer=renderer,
            clock=session.VirtualClock() if simulated else session.WallClock(),
            machine=machine,
            screen=headset.screen if headset else None,
            watchdog=headset.watchdog if headset else None,
            operators=operators or OperatorControl(NoOperator()),
            durability=self._durability,
            speaker=SilentSpeaker() if simulated else None,
            jumps=not self._frames,
        )

    def _headset_for(self) -> HeadsetFor:
        """Return the headset of each scene where there is no live one."""
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

    def _simulated(self, enrolment: OpenEnrolment) -> Respondent:
        from vrcomfort.respondent import SimulatedRespondent

        settings, seed = self._protocol.simulation, enrolment.design.seed
        return SimulatedRespondent(
            settings,
            participant=enrolment.participant,
            seed=seed,
            covariates=enrolment.covariates,
        )


def _require_trust(code: TaskCode, given: str | None, ask: AskForCode | None) -> None:
    """Raise `InputError` where this user has not consented to run a protocol's Python files."""
    from vrcomfort.records.trusted_code import is_trusted, require_given_hash, trust

    if given is not None:
        require_given_hash(code, given)
        trust(code)
    elif code.files and not is_trusted(code):
        if ask is None or not ask(code):
            files = ", ".join(sorted(code.files))
            message = f"this protocol runs its own Python files ({files}), which can do anything"
            message = f"{message} you can, and you have not consented to these versions; read them"
            raise InputError(f"{message}, then: --trust {code.sha256}", file=code.folder)
        trust(code)


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


def _scene_loader(protocol: Protocol, frames: bool, note: Note) -> Callable[[str], Any]:
    """Return the loader of a session's scenes."""
    from vrcomfort.session import scenes_for

    return partial(_load_scene, note=note) if frames else scenes_for(protocol)


def _load_scene(source: str, note: Note) -> Scene:
    from vrcomfort.scene.load import load_scene

    scene = load_scene(source)
    for warning in scene.warnings:
        note(warning)
    return scene


def outcome_sentence(outcome: RunOutcome, out: Path) -> str:
    """Return a sentence on a participant's sessions: their numbers, status and folder."""
    sessions = ", ".join(map(str, outcome.sessions))
    note = f" ({outcome.note})" if outcome.note else ""
    return (
        f"{outcome.participant} ({outcome.sequence}): session {sessions} recorded, "
        f"{outcome.status}{note}; {out / f'sub-{outcome.participant}'}"
    )
