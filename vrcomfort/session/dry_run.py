"""A session without pictures: everything but drawing, to see that it runs and how long it takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vrcomfort.csv_table import CsvTable
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.frame import EYE_HEIGHT_M, FocusSample, Frame, GpuTime, HeadsetEvent, ImageHash
from vrcomfort.geometry import Fov, Gaze, Pose, View
from vrcomfort.protocol import Condition, Protocol
from vrcomfort.records import EventRow, session_folder
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.scene.load import load_scene
from vrcomfort.session.clock import VirtualClock
from vrcomfort.session.enrolment import open_enrolment
from vrcomfort.session.interfaces import LoadScene
from vrcomfort.session.run import run
from vrcomfort.session.standing import without_meshes

_LEAST_HZ = 4.0
"""Frames further apart would be told as a freeze."""


@dataclass(frozen=True)
class SessionLength:
    """How long one session of a protocol takes somebody who does not stop.

    Parameters
    ----------
    group
        Blank without groups.
    questions_s
        At the pace of simulated participants.
    """

    group: str
    sequence: str
    session: int
    exposure_s: float
    training_s: float
    rest_s: float
    questions_s: float

    @property
    def total_s(self) -> float:
        """Return the length of the session."""
        return self.exposure_s + self.training_s + self.rest_s + self.questions_s


def dry_run(protocol: Protocol, folder: Path) -> list[SessionLength]:
    """Take one simulated participant of each group through all sessions, drawing nothing.

    Parameters
    ----------
    folder
        Takes the study that is made on the way.

    Raises
    ------
    InputError
        If a session does not come to its end.
    """
    study = folder / "dry_run"
    protocol = _that_ends_for_nobody(protocol)
    design = build_design(protocol)
    wanted = {group.name for group in protocol.groups} or {""}
    lengths: list[SessionLength] = []
    number = 0
    while wanted:
        number += 1
        name = f"P{number:02d}"
        sequence = _run(protocol, study, name, design.imagined(number))
        group = design.group_of(sequence)
        if group in wanted:
            wanted.remove(group)
            sessions = range(1, design.sessions + 1)
            lengths += [_length(study, name, group, sequence, each) for each in sessions]
    return lengths


def _that_ends_for_nobody(protocol: Protocol) -> Protocol:
    """Return the protocol with a validation of the gaze that ends no session, whatever it finds."""
    validation = protocol.gaze_validation
    if validation is None:
        return protocol
    noting = validation.model_copy(update={"above": "note"})
    return protocol.model_copy(update={"gaze_validation": noting})


def _run(protocol: Protocol, study: Path, name: str, covariates: dict[str, str]) -> str:
    stays = {
        "rate_per_min": 0.0,
        "baseline_sd": 0.0,
        "noise_sd": 0.0,
        "hazard_per_min": 0.0,
        "question_hazard": 0.0,
    }
    settings = protocol.simulation.model_copy(update=stays)
    respondent = SimulatedRespondent(settings, participant=name, seed=0)
    with open_enrolment(
        protocol, name, study=study, respondent=respondent.name, covariates=covariates
    ) as enrolment:
        outcome = run(
            enrolment,
            respondent=respondent,
            headset_for=lambda _name, _scene: _Still(_rate_hz(protocol)),
            load_scene=_loader(protocol),
            renderer=_NoPictures(),
            clock=VirtualClock(),
            durability="session_end",
        )
    if outcome.status != "completed":
        raise InputError(f"a rehearsed session ended early: {outcome.note or outcome.status}")
    return outcome.sequence


def _loader(protocol: Protocol) -> LoadScene:
    """Return what loads as much of a scene as a session without pictures needs."""
    if protocol.tasks:
        return load_scene
    return without_meshes if protocol.views else lambda _source: None


def _rate_hz(protocol: Protocol) -> float:
    """Return how many frames a second are enough to meet everything that falls due."""
    often = [
        20 / min(map(protocol.length_s, protocol.scenes)),
        *(4 / ratings.timeout_s for ratings in protocol.ratings),
    ]
    return max(_LEAST_HZ, *often)


def _length(study: Path, name: str, group: str, sequence: str, session: int) -> SessionLength:
    table = CsvTable.read(session_folder(study, name, session) / EventRow.FILE, appended=True)
    events = list(table.dicts())

    def lasted(what: str) -> float:
        return sum(float(e["duration_s"] or 0) for e in events if e["name"] == what)

    known = {f"{what}_s": lasted(what) for what in ("exposure", "training", "rest")}
    end_s = max(float(event["onset_s"]) for event in events if event["name"] == "session_end")
    return SessionLength(
        group, sequence, session, questions_s=max(end_s - sum(known.values()), 0.0), **known
    )


@dataclass
class _Still:
    """A headset whose head stands still and that shows nothing."""

    refresh_hz: float
    name: str = "none"
    image_size_px: tuple[int, int] = (16, 16)

    @property
    def details(self) -> dict[str, Any]:
        return {}

    def frames(self) -> Iterator[Frame]:
        head = Pose(np.array([0.0, EYE_HEIGHT_M, 0.0]))
        view = View(head, Fov(-0.8, 0.8, 0.8, -0.8))
        period_ns = round(1e9 / self.refresh_hz)
        frame = Frame(0, 0, period_ns, head, (view, view), Pose(), gaze=Gaze(head))
        index = 0
        while True:
            time_ns = index * period_ns
            yield replace(
                frame, index=index, predicted_display_time_ns=time_ns, discontinuity=index == 0
            )
            index += 1

    def submit(self, frame: Frame, eyes: Any) -> None:
        """Show nothing."""

    def take_events(self) -> list[HeadsetEvent]:
        return []


@dataclass(frozen=True)
class _Unseen:
    eyes: tuple[None, None] = (None, None)
    focus_samples: tuple[FocusSample, ...] = ()
    max_blur_px: float | None = 0.0
    cpu_ms: float | None = None
    gpu_times: tuple[GpuTime, ...] | None = None
    hashed: bool = False
    image_hashes: tuple[ImageHash, ...] = ()


class _NoPictures:
    """A renderer that draws nothing."""

    def begin(self, scene: Any, condition: Condition) -> None:
        """Prepare nothing."""

    def render(self, frame: Frame, scene_time_s: float) -> _Unseen:  # noqa: ARG002
        return _Unseen()

    def drain(self) -> tuple[FocusSample, ...]:
        return ()

    def drain_times(self) -> tuple[GpuTime, ...]:
        return ()

    def drain_hashes(self) -> tuple[ImageHash, ...]:
        return ()

    def clamps(self) -> tuple[str, ...]:
        return ()
