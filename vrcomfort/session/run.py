"""Takes one participant through their sessions and keeps everything that happened."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from vrcomfort.protocol import Protocol
from vrcomfort.records import Machine
from vrcomfort.respondent import Respondent
from vrcomfort.session.clock import Clock
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.interfaces import HeadsetFor, LoadScene, ProgressCallback, Renderer
from vrcomfort.session.interfaces import silent as no_progress
from vrcomfort.session.enrolment import reserve
from vrcomfort.session.participant_sessions import Outcome


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
    resume: bool = False,
    machine: Machine | None = None,
    screen: PanelScreen | None = None,
    progress: ProgressCallback = no_progress,
) -> Outcome:
    """Run the sessions of one participant that are not on disk yet, or those asked for.

    For parameters and errors see `reserve` and `Reservation.run`.
    """
    with reserve(
        protocol, participant, study=study, respondent=respondent.name, seed=seed,
        sessions=sessions, exposure_s=exposure_s, resume=resume,
    ) as place:  # fmt: skip
        return place.run(
            load_scene=load_scene, headset_for=headset_for, renderer=renderer,
            respondent=respondent, clock=clock, machine=machine, screen=screen, progress=progress,
        )  # fmt: skip
