"""What `run` and `simulate` share: a study's folder, what draws its scenes, and who answers."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.cli.terminal import console, progress_bar, warn
from vrcomfort.cli.playback import PlaybackIn, describe_machine, make_renderer
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol

if TYPE_CHECKING:
    from vrcomfort.cli.run_openxr import LiveLab
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent import Respondent
    from vrcomfort.scene.data import Scene
    from vrcomfort.session import Outcome, Progress, Reservation


class RespondentKind(StrEnum):
    """Who answers."""

    SIMULATED = "simulated"
    TERMINAL = "terminal"
    PANEL = "panel"


class StudyLab:
    """One study's protocol, folder, headset and renderer; scenes are loaded once.

    Parameters
    ----------
    playback
        Where there is no live headset.

    Raises
    ------
    InputError
        If exposures would be longer than the protocol's.
    """

    def __init__(
        self,
        protocol: Protocol,
        study: Path,
        playback: PlaybackIn,
        seed: int | None,
        exposure_s: float | None,
    ) -> None:
        self._protocol = protocol
        self._study = study
        self._playback = playback
        self._seed = seed
        protocol.shown_s(exposure_s)  # refuses a longer one before anything is made
        self._exposure_s = exposure_s
        self._rendering: tuple[StereoRenderer, Machine] | None = None
        self._load_scene = lru_cache(maxsize=None)(_load_scene)

    def reserve(
        self,
        participant: str,
        sessions: list[int] | None,
        kind: RespondentKind,
        *,
        resume: bool = False,
    ) -> AbstractContextManager[Reservation]:
        """Return a participant who can be run; see `session.reserve`."""
        from vrcomfort.session import enrolment as reserve

        return reserve(
            self._protocol,
            participant,
            study=self._study,
            respondent=kind,
            seed=self._seed,
            sessions=sessions,
            exposure_s=self._exposure_s,
            resume=resume,
        )

    def run(
        self,
        place: Reservation,
        kind: RespondentKind,
        tell: Any,
        live: LiveLab | None = None,
    ) -> Outcome:
        """Run a participant's sessions."""
        from vrcomfort.session import VirtualClock, WallClock

        respondent = self._respondent(kind, place, live)
        renderer, machine = (live.renderer, live.machine) if live else self._windowless()
        return place.run(
            load_scene=self._load_scene,
            headset_for=live.headset_for if live else self._playback,
            renderer=renderer,
            respondent=respondent,
            clock=VirtualClock() if kind is RespondentKind.SIMULATED else WallClock(),
            machine=machine,
            screen=live.screen if live else None,
            progress=tell,
        )

    def _windowless(self) -> tuple[StereoRenderer, Machine]:
        if self._rendering is None:
            renderer = make_renderer(self._playback.size_px)
            self._rendering = renderer, describe_machine(renderer, self._protocol)
        return self._rendering

    def _respondent(
        self, kind: RespondentKind, place: Reservation, live: LiveLab | None
    ) -> Respondent:
        from vrcomfort.respondent import SimulatedRespondent, TerminalRespondent

        if kind is RespondentKind.SIMULATED:
            settings, seed = self._protocol.simulation, place.design.seed
            return SimulatedRespondent(settings, participant=place.participant, seed=seed)
        if kind is RespondentKind.TERMINAL:
            return TerminalRespondent(console())
        if live is None:
            raise InputError("--respondent panel needs a headset to answer in")
        return live.panel


def _load_scene(source: str) -> Scene:
    from vrcomfort.scene.load import load_scene

    scene = load_scene(source)
    for warning in scene.warnings:
        warn(warning)
    return scene


class SessionBars(ExitStack):
    """A bar for each exposure and rest; the questionnaires speak for themselves."""

    def __init__(self, quiet: bool) -> None:
        super().__init__()
        self._quiet = quiet
        self._title = ""
        self._done = 0.0

    def tell(self, progress: Progress) -> None:
        """Show how far a step of the session has come."""
        timed = progress.step in {"training", "exposure", "rest"}
        title = f"{progress.step} {progress.trial or ''}".strip() if timed else ""
        if title != self._title:
            self.close()
            self._title, self._done = title, 0.0
            if title:
                bar = progress_bar(title, round(progress.total), quiet=self._quiet)
                self._advance = self.enter_context(bar)
        if title:
            self._advance(progress.done - self._done)
            self._done = progress.done


def sentence(outcome: Outcome, out: Path) -> str:
    """Say what became of a participant's sessions."""
    sessions = ", ".join(map(str, outcome.sessions))
    note = f" ({outcome.note})" if outcome.note else ""
    return (
        f"{outcome.participant} ({outcome.sequence}): session {sessions} recorded, "
        f"{outcome.status}{note}; {out / f'sub-{outcome.participant}'}"
    )
