"""A task in the exposures of a session: its balls in the scene, its presses, its rows."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose
from vrcomfort.headset.base import HasInputs
from vrcomfort.protocol.timeline import TrialPlace
from vrcomfort.records import TaskRow
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.scene.boxes import node_box
from vrcomfort.scene.data import Scene
from vrcomfort.scene.markers import Markers, Shown
from vrcomfort.scene.ray_cast import RayCaster
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.settings import did_you_mean
from vrcomfort.tasks import Ball, Demand, Result, Surroundings, Task, TaskFrame, TaskSettings

_STREAM = 3
"""Which of a trial's random streams is the task's."""
_TOGETHER = 200
"""Rows that are written together in a session without frames."""


@dataclass
class TaskRun:
    """One task in one exposure; made before the scene is drawn, which gets its balls.

    Parameters
    ----------
    scene
        None in a session without pictures that needs none.
    attempt
        At this trial.
    duration_s
        How long it lasts at most.
    stream
        Number of its random numbers; without it, that of the trial.
    keep
        Takes what comes of it; without it, that is written into ``tasks.csv``.
    """

    context: SessionContext
    events: EventLog
    place: TrialPlace
    settings: TaskSettings
    scene: Scene | None
    attempt: int
    resumed: bool
    duration_s: float
    stream: int | None = None
    keep: Callable[[Sequence[Result]], None] | None = None
    elapsed_s: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self._task: Task = self.settings.start(self._surroundings())
        self._markers = (
            Markers(self.scene, self._task.looks)
            if self.scene and self._task.looks and not self.context.jumps
            else None
        )
        self._shown = self._markers.shown() if self._markers else ()
        self._rows: list[TaskRow] = []
        self._began_s: float | None = None
        self._wanted: str | None = None

    @property
    def drawn(self) -> Any:
        """Return the scene with the task's balls in it."""
        return self._markers.scene if self._markers else self.scene

    @property
    def done(self) -> bool:
        """Whether the task is done, so that the exposure may end; see `interfaces.Doing`."""
        return self._task.done and self.context.protocol.exposure_ends == "task"

    def demand(self, frame: Frame) -> Demand | None:
        """Return the ideal action now."""
        del frame
        return self._task.demand()

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn: move the balls, and write complete results.

        Parameters
        ----------
        elapsed_s
            Of the exposure.
        scene_time_s
            Of the scene's animations.
        """
        self._scene_time_s = scene_time_s
        if self._began_s is None:
            self._began_s = self.context.clock.now_s() - elapsed_s
            if isinstance(self.context.respondent, SimulatedRespondent):
                self.context.respondent.start_task(self._stream, self.place.condition or "")
        self.elapsed_s = elapsed_s
        self._write(self._task.step(self._moment(frame, headset, elapsed_s)))
        if self._markers is not None:
            self._markers.place(
                [
                    None if ball is None else (ball.position_m, ball.radius_m)
                    for ball in self._task.balls()
                ]
            )
        wanted = self._task.wanted
        if wanted != self._wanted:
            self._wanted = wanted
            self.events.event_soon("task_target", detail=wanted or "")

    def next_s(self) -> float | None:
        """Return when the task or the participant acts next; see `interfaces.Activity`."""
        due_s, respondent = self._task.next_s(), self.context.respondent
        if due_s is None or not isinstance(respondent, SimulatedRespondent) or respondent.has_eyes:
            return None
        if self._began_s is None:
            return 0.0
        return max(self.elapsed_s, min(due_s, respondent.next_press_s(self._task.demand())))

    def changed(self) -> tuple[Shown, ...]:
        """Return the balls that are drawn otherwise than at the last call, for the record.

        Nothing where nothing is drawn.
        """
        if self._markers is None or self.context.jumps:
            return ()
        before, self._shown = self._shown, self._markers.shown()
        return tuple(now for now, was in zip(self._shown, before, strict=True) if now != was)

    def finish(self) -> None:
        """End with the exposure, however it ended; once."""
        if self._began_s is not None:
            self._write(self._task.finish(self.elapsed_s))
            self._hand_over()
            self._began_s = None

    def _moment(self, frame: Frame, headset: object, time_s: float) -> TaskFrame:
        head = frame.avatar_pose @ frame.head_pose
        gaze = frame.gaze
        seen = frame.avatar_pose @ gaze.pose if gaze is not None and gaze.valid else None
        pressed: list[Pose | None] = []
        held: list[Pose | None] = []
        respondent = self.context.respondent
        if isinstance(respondent, SimulatedRespondent):
            ray = respondent.act(self._task.demand(), head, time_s)
            pressed = [] if ray is None else [ray]
        elif isinstance(headset, HasInputs) and not self.context.panel_stands:
            inputs = headset.inputs()
            aims = [hand.aim for hand in inputs.hands if hand.select]
            aims += [None] if inputs.keys.enter else []
            pressed = [None if aim is None else frame.avatar_pose @ aim for aim in aims]
            held = [hand.aim and frame.avatar_pose @ hand.aim for hand in inputs.hands if hand.held]
        return TaskFrame(time_s, head, seen, tuple(pressed), tuple(held))

    @property
    def _stream(self) -> int:
        return (self.place.trial or 0) if self.stream is None else self.stream

    def _write(self, results: Sequence[Result]) -> None:
        if self.keep is not None:
            self.keep(results)
            return
        self._rows += map(self._row, results)
        # Without frames, rows come faster than a thread wakes up to write them.
        if len(self._rows) >= (_TOGETHER if self.context.jumps else 1):
            self._hand_over()

    def _hand_over(self) -> None:
        rows, self._rows = self._rows, []
        self.events.recorder.write_soon(*rows)

    def _row(self, result: Result) -> TaskRow:
        x_m, y_m, z_m = result.position_m or (None, None, None)
        return TaskRow(
            participant=self.context.participant,
            session=self.events.session,
            trial=self.place.trial or 0,
            condition=self.place.condition or "",
            attempt=self.attempt,
            task=self.settings.name,
            kind=result.kind,
            number=result.number,
            what=result.what,
            onset_s=round((self._began_s or 0.0) + result.time_s, 9),
            reaction_s=result.reaction_s,
            hit=result.hit,
            error_deg=result.error_deg,
            distance_m=result.distance_m,
            x_m=x_m,
            y_m=y_m,
            z_m=z_m,
            targets=result.targets,
            hits=result.hits,
            shots=result.shots,
            score=result.score,
            deaths=result.deaths,
            resumed=int(self.resumed),
        )

    def _surroundings(self) -> Surroundings:
        context, scene = self.context, self.scene
        caster = _caster_in(scene) if scene else None
        self._scene_time_s = 0.0
        free_m: Callable[[Pose], float] = (
            (lambda ray: caster.cast(ray, self._scene_time_s).distance_m)
            if caster
            else (lambda _: np.inf)
        )
        return Surroundings(
            random=task_random(
                context.seed, context.participant, self.events.session, self._stream
            ),
            duration_s=self.duration_s,
            spawn=scene.spawn if scene else Pose(),
            thing=lambda name: _SceneObject.of(scene, name, self.place.scene),
            free_m=free_m,
        )


@lru_cache(maxsize=2)
def _caster_in(scene: Scene) -> RayCaster:
    """Return the ray caster of a scene, which is used again in its next exposure."""
    return RayCaster(scene)


@dataclass(frozen=True)
class _SceneObject:
    """A node of a scene, with all that hangs on it."""

    scene: Scene
    index: int

    @classmethod
    def of(cls, scene: Scene | None, name: str, called: str) -> _SceneObject:
        """Find a node by its name.

        Raises
        ------
        InputError
            If the scene has none of this name.
        """
        nodes = () if scene is None else scene.nodes
        for index, node in enumerate(nodes):
            if node.name == name and scene is not None:
                return cls(scene, index)
        hint = did_you_mean(name, [node.name for node in nodes])
        raise InputError(f"a task names `{name}`, which scene {called} does not have; {hint}")

    def __call__(self, time_s: float) -> Ball:
        """Return the bounding sphere of a node's meshes."""
        low, high = node_box(self.scene, self.index, time_s)
        return Ball((low + high) / 2, float(np.linalg.norm(high - low)) / 2)


def task_random(
    seed: int, participant: str, session: int, trial: int, stream: int = _STREAM
) -> np.random.Generator:
    """Return a task's random generator: the same at each attempt at a trial."""
    person = int.from_bytes(hashlib.sha256(participant.encode()).digest()[:4])
    key = (person, session, trial, stream)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
