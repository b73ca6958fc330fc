"""Practice: blocks of exposures before trials, repeated until they go well enough."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from vrcomfort.errors import headset_ended
from vrcomfort.protocol import Trial
from vrcomfort.protocol.session_steps import Practice
from vrcomfort.protocol.timeline import WHOLE_SESSION, PracticeStep, TrialPlace
from vrcomfort.records import Interrupted, PracticeRow
from vrcomfort.records.interrupted import Practised
from vrcomfort.respondent import Withdrew
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.exposure import FrameLoop, Stimulus
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.no_frames import EventLoop
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.session.ratings import StopRule
from vrcomfort.session.task_run import TaskRun, task_random
from vrcomfort.session.trial import TrialRunner
from vrcomfort.tasks import Result

_STATUS: Mapping[type[Exception], str] = {
    Skipped: "skipped",
    Redone: "redone",
    Withdrew: "withdrawn",
}
_STREAMS = 2_000_000
"""From here on are the random numbers of practice, so that no trial has them."""


@dataclass
class _Block:
    """One repetition of a block, with its trials and rows."""

    step: PracticeStep
    repetition: int
    trials: Sequence[Trial]
    rows: list[PracticeRow] = field(default_factory=list)

    @property
    def met(self) -> bool | None:
        """Return whether it went well enough; None without a criterion."""
        scores = [row.score for row in self.rows if row.score is not None]
        return self.step.practice.met(scores, sum(row.hits or 0 for row in self.rows))


class PracticeRunner:
    """The practice of one session.

    Parameters
    ----------
    interrupted
        How far an interrupted session came: practice that was over is not shown again.
    """

    def __init__(
        self,
        context: SessionContext,
        events: EventLog,
        log: FrameLog,
        trials: TrialRunner,
        interrupted: Interrupted | None,
    ) -> None:
        self._context = context
        self._events = events
        self._log = log
        self._trials = trials
        self._resumed = interrupted is not None
        self._before = interrupted.practised if interrupted else {}

    def run(self, step: PracticeStep) -> None:
        """Show a block of practice until it has gone well enough, or often enough.

        Raises
        ------
        StopRule
            If it never went well enough, and the protocol ends something with it.
        Withdrew
            If the participant stops.
        """
        practice = step.practice
        before = self._before.get(practice.name, Practised(0, 0, over=False))
        repetition, whole = before.begun, before.whole
        while True:
            repetition += 1
            last = whole + 1 >= practice.at_most or not practice.has_criterion
            block = _Block(step, repetition, self._shown(practice, repetition))
            try:
                self._block(block, last=last)
            except Skipped:
                return
            except Redone:
                continue
            whole += 1
            if block.met is not False:
                return
            if last:
                self._give_up(practice, whole)
                return

    def _give_up(self, practice: Practice, repetitions: int) -> None:
        """Report an unmet criterion; end session or study as the protocol says."""
        reason = f"practice {practice.name} was not good enough in {repetitions} repetitions"
        self._events.event("practice_not_met", detail=reason)
        self._events.tell("notice", WHOLE_SESSION, 0, 0, reason)
        if practice.otherwise != "go_on":
            raise StopRule(reason, practice.otherwise, "practice")

    def _shown(self, practice: Practice, repetition: int) -> Sequence[Trial]:
        """Return the trials of a repetition; `draw` draws anew for each."""
        if practice.draw is None:
            return practice.trials
        context, number = self._context, self._events.session
        own = context.sequence.sessions[number - 1]
        random = self._random(practice, repetition)
        order = random.permutation(len(own))[: practice.draw]
        return [own[index] for index in order]

    def _random(self, practice: Practice, repetition: int) -> np.random.Generator:
        context = self._context
        stream = self._stream(practice, repetition, 0)
        return task_random(context.seed, context.participant, self._events.session, stream)

    def _stream(self, practice: Practice, repetition: int, number: int) -> int:
        index = [each.name for each in self._context.protocol.practice].index(practice.name)
        return _STREAMS + (index * 1000 + repetition) * 1000 + number

    def _block(self, block: _Block, *, last: bool) -> None:
        """Show the exposures of a block, and write a row for each."""
        for number, trial in enumerate(block.trials, start=1):
            start_s = self._context.clock.now_s()
            status = "aborted"
            results: list[Result] = []
            try:
                self._expose(block, number, trial, results)
                status = "completed"
            except (Skipped, Redone, Withdrew) as reason:
                status = _STATUS[type(reason)]
                raise
            finally:
                row = self._row(block, number, trial, status, start_s, results)
                self._write(block, row, last=last)
                detail = (
                    f"{block.step.practice.name}, repetition {block.repetition}: {_named(trial)}"
                )
                self._events.event("practice", start_s, detail=detail)

    def _write(self, block: _Block, row: PracticeRow, *, last: bool) -> None:
        """Write a row; the last of a whole block says whether that was good enough."""
        block.rows.append(row)
        if row.status == "skipped":
            row = replace(row, over=1)
        elif row.status == "completed" and row.number == len(block.trials):
            met = block.met
            over = int(last or met is not False)
            row = replace(row, met=None if met is None else int(met), over=over)
        self._events.recorder.write(row)

    def _expose(self, block: _Block, number: int, trial: Trial, results: list[Result]) -> None:
        """Show one exposure; add its task's results to `results`."""
        context = self._context
        protocol, practice = context.protocol, block.step.practice
        place = TrialPlace(condition=trial.condition, scene=trial.scene)
        headset, start = self._trials.start_pose_of(place)
        full_s = practice.exposure_s or protocol.length_s(trial.scene)
        shown_s = full_s / context.time_scale
        condition = protocol.condition(trial.condition, trial.scene)
        settings = protocol.task_of(trial)
        task = (
            None
            if settings is None
            else TaskRun(
                context,
                self._events,
                place,
                settings,
                start.scene,
                attempt=block.repetition,
                resumed=self._resumed,
                duration_s=shown_s,
                stream=self._stream(practice, block.repetition, number),
                keep=results.extend,
            )
        )
        context.renderer.begin(task.drawn if task else start.scene, condition)
        kind = EventLoop if context.jumps else FrameLoop
        loop = kind(context, headset, self._events, self._log, start.path)
        words = f"{block.step.words}, repetition {block.repetition}: {_named(trial)}"
        context.operators.begin("training", words)
        tell = partial(self._events.tell, "training", place, total=shown_s)
        stimulus = Stimulus(0, trial.condition, shown_s, context.time_scale)
        ended = loop.show(stimulus, task=task, progress=tell)
        context.respondent.leave()
        if ended == "headset_ended":
            raise headset_ended("in practice")

    def _row(
        self,
        block: _Block,
        number: int,
        trial: Trial,
        status: str,
        start_s: float,
        results: Sequence[Result],
    ) -> PracticeRow:
        whole = next((each for each in reversed(results) if each.kind == "trial"), None)
        settings = self._context.protocol.task_of(trial)
        return PracticeRow(
            participant=self._context.participant,
            session=self._events.session,
            practice=block.step.practice.name,
            before_trial=block.step.place.trial or 0,
            repetition=block.repetition,
            number=number,
            condition=trial.condition,
            scene=trial.scene,
            task=settings.name if settings else "",
            start_s=start_s,
            end_s=self._context.clock.now_s(),
            status=status,
            targets=whole.targets if whole else None,
            hits=whole.hits if whole else None,
            shots=whole.shots if whole else None,
            score=whole.score if whole else None,
        )


def _named(trial: Trial) -> str:
    return f"{trial.condition} in {trial.scene}"
