"""A session without pictures: everything but drawing, to see that it runs and how long it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.headset.sound import SilentSpeaker
from vrcomfort.protocol import Protocol
from vrcomfort.records import EventRow, Study
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.session.context import SessionSettings
from vrcomfort.session.enrolment import open_enrolment
from vrcomfort.session.no_frames import NoPictures, StillHeadset, scenes_for
from vrcomfort.session.run import run
from vrcomfort.tasks import OwnTask
from vrcomfort.tasks.exploration import Exploration


@dataclass(frozen=True)
class SessionLength:
    """The length of one session without dropout.

    Parameters
    ----------
    group
        Blank without groups.
    questions_s
        At the pace of simulated participants.
    in_a_row, in_a_row_s
        Most exposures that follow each other without a rest, and how long they are together.
    """

    group: str
    sequence: str
    session: int
    exposure_s: float
    training_s: float
    rest_s: float
    questions_s: float
    in_a_row: int
    in_a_row_s: float

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
    protocol = _without_task_code(protocol)
    design = build_design(protocol)
    wanted = {group.name for group in protocol.groups} or {""}
    lengths: list[SessionLength] = []
    number = 0
    while wanted:
        number += 1
        name = f"P{number:02d}"
        sequence = _run(protocol, study, name, design.simulated_covariates(number))
        group = design.group_of(sequence)
        if group in wanted:
            wanted.remove(group)
            sessions = range(1, design.sessions + 1)
            lengths += [_length(study, name, group, sequence, each) for each in sessions]
    return lengths


def _run(protocol: Protocol, study: Path, name: str, covariates: dict[str, str]) -> str:
    stays: dict[str, object] = {
        "rate_per_min": 0.0,
        "baseline_sd": 0.0,
        "noise_sd": 0.0,
        "hazard_per_min": 0.0,
        "question_hazard": 0.0,
        "screened_out": 0.0,
        "break_extra_s": 0.0,
        "eyes": None,  # or a validation of them could end a session
    }
    settings = protocol.simulation.model_copy(update=stays)
    respondent = SimulatedRespondent(settings, participant=name, seed=0)
    with open_enrolment(
        protocol, name, study=study, respondent=respondent.name, covariates=covariates
    ) as enrolment:
        outcome = run(
            enrolment,
            SessionSettings(
                respondent=respondent,
                headset_for=lambda _name, _scene: StillHeadset(_steps_hz(protocol)),
                load_scene=scenes_for(protocol),
                renderer=NoPictures(),
                speaker=SilentSpeaker(),
                jumps=True,
                durability="session_end",
            ),
        )
    if outcome.status != "completed":
        raise InputError(f"a rehearsed session ended early: {outcome.note or outcome.status}")
    return outcome.sequence


def _without_task_code(protocol: Protocol) -> Protocol:
    """Return the protocol with nothing to do in place of own tasks: their code is not run.

    Nothing is hit or scored in them, which must not end a session after practice.
    """
    own = {each.name for each in protocol.tasks if isinstance(each, OwnTask)}
    if not own:
        return protocol
    practice = [each.model_copy(update={"otherwise": "go_on"}) for each in protocol.practice]
    without = protocol.model_copy(update={"practice": tuple(practice)})
    without._tasks = {
        name: Exploration(name=name, kind="exploration") if name in own else task
        for name, task in protocol._tasks.items()
    }
    return without


def _steps_hz(protocol: Protocol) -> float:
    """Return how often a second tasks go on: coarser than people would, but of any length."""
    return max(4.0, 20 / protocol.longest_s)


def _length(study: Path, name: str, group: str, sequence: str, session: int) -> SessionLength:
    events = list(Study(study).session(name, session).text_rows(EventRow))

    def lasted(what: str) -> float:
        return sum(float(e["duration_s"] or 0) for e in events if e["name"] == what)

    known = {f"{what}_s": lasted(what) for what in ("exposure", "training", "rest")}
    known["training_s"] += lasted("practice") + lasted("eye_height")
    end_s = max(float(event["onset_s"]) for event in events if event["name"] == "session_end")
    in_a_row, in_a_row_s = _most_in_a_row(events)
    return SessionLength(
        group,
        sequence,
        session,
        questions_s=max(end_s - sum(known.values()), 0.0),
        in_a_row=in_a_row,
        in_a_row_s=in_a_row_s,
        **known,
    )


def _most_in_a_row(events: Sequence[Mapping[str, str]]) -> tuple[int, float]:
    """Return how many exposures follow each other without a rest, at most, and for how long."""
    most = now = (0, 0.0)
    for event in events:
        if event["name"] == "rest":
            now = (0, 0.0)
        elif event["name"] == "exposure":
            now = (now[0] + 1, now[1] + float(event["duration_s"] or 0))
            most = max(most, now)
    return most
