"""Shows a protocol's dearest condition for a time, before people come, and counts its frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from vrcomfort.headset.base import HasInputs, Headset
from vrcomfort.headset.timing import RATE_CHANGED
from vrcomfort.protocol import Protocol, Trial
from vrcomfort.protocol.model import trials_of
from vrcomfort.seen_time import SeenState
from vrcomfort.session.frame_log import FrameLog, TrialTiming, trial_flags
from vrcomfort.session.start_pose import StartPose, start_pose_of

if TYPE_CHECKING:
    from vrcomfort.frame import Frame
    from vrcomfort.records import Row
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.session.interfaces import LoadScene

COST_ROUNDS = 3
"""Looks ahead and back, each of which is timed."""
EMPTY: Callable[..., None] = lambda *_: None  # noqa: E731


class Cost(NamedTuple):
    """The time that one frame of a condition takes in a scene, until all is drawn."""

    scene: str
    condition: str
    frame_ms: float

    @property
    def words(self) -> str:
        """Return the condition and its scene, in words."""
        return f"{self.condition} in {self.scene}"


def shown_trials(protocol: Protocol) -> list[Trial]:
    """Return each pair of condition and scene that a session can show."""
    order = protocol.order
    if order.rule == "explicit":
        sessions = (session for each in order.sequences for session in each.sessions)
        trials = [trial for session in sessions for trial in session]
    else:
        trials = list(trials_of(protocol))
    return list({(each.scene, each.condition): each for each in trials}.values())


def start_of(protocol: Protocol, scene: str, load_scene: LoadScene) -> StartPose:
    """Load a trial's scene, as a session does."""
    loaded = load_scene(protocol.scene_source(scene))
    walks = protocol.locomotion.mode != "off"
    return start_pose_of(loaded, protocol.view(scene), walks=walks)


def costs(
    protocol: Protocol,
    renderer: StereoRenderer,
    load_scene: LoadScene,
    advance: Callable[..., object] = EMPTY,
) -> list[Cost]:
    """Draw every condition in every scene for a moment; return the dearest first."""
    found = []
    for trial in shown_trials(protocol):
        start = start_of(protocol, trial.scene, load_scene)
        condition = protocol.condition(trial.condition, trial.scene)
        frame_ms = _frame_ms(renderer, start.scene, condition)
        found.append(Cost(trial.scene, trial.condition, frame_ms))
        advance(1)
    return sorted(found, key=lambda each: each.frame_ms, reverse=True)


def _frame_ms(renderer: StereoRenderer, scene: Any, condition: Any) -> float:
    from vrcomfort.render.pipeline import looks_around

    renderer.begin(scene, condition)
    took_ms = []
    for frame in looks_around(scene.spawn) * COST_ROUNDS:
        renderer.ctx.finish()
        began_s = time.perf_counter()
        renderer.render(frame, 0.0)
        renderer.ctx.finish()
        took_ms.append((time.perf_counter() - began_s) * 1e3)
    return median(took_ms)


class _NoRows:
    """Takes rows, and keeps none."""

    def write(self, *rows: Row) -> None:
        """Take rows."""


@dataclass
class TimedShow:
    """Measurements of a condition shown for a time.

    Parameters
    ----------
    period_ms
        Of the display, as it was fixed at the start.
    head_heights_m
        Of the head over the floor, where it was tracked.
    hands_seen
        Frames in which the left and the right hand were known.
    gaze_seen
        Frames with a valid gaze.
    """

    cost: Cost
    timing: TrialTiming = field(default_factory=TrialTiming)
    period_ms: float = 0.0
    times_gpu: bool = False
    head_heights_m: list[float] = field(default_factory=list)
    hands_seen: list[int] = field(default_factory=lambda: [0, 0])
    gaze_seen: int = 0

    def busy_ms(self, percent: float = 99) -> float | None:
        """Return the time that `percent` of the frames take at most, on processor or GPU."""
        parts = (each.percentile_ms(percent) for each in (self.timing.cpu, self.timing.gpu))
        return max((each for each in parts if each is not None), default=None)

    @property
    def margin_percent(self) -> float | None:
        """Return the share of a period that is left in 99 % of the frames; 0 where none is."""
        busy_ms = self.busy_ms()
        if busy_ms is None or not self.period_ms:
            return None
        return max(round(100 * (1 - busy_ms / self.period_ms), 1), 0.0)

    def holds(self, protocol: Protocol) -> bool:
        """Return whether the display's rate is held, by the limits of the protocol.

        A headset that is played back drops no frame, however long one takes: half of them must be
        drawn within a period, too.
        """
        timing, limits = self.timing, protocol.flag_above_percent
        late = timing.seen.percent(SeenState.HALF_RATE) > limits.half_rate
        frozen = timing.seen.percent(SeenState.FROZEN) > limits.frozen
        dropped = (timing.dropped_percent or 0.0) > protocol.max_dropped_percent
        slow = (self.busy_ms(50) or 0.0) > self.period_ms
        return bool(timing.frames) and not (late or frozen or dropped or slow or timing.rate_change)

    def facts(self, protocol: Protocol) -> dict[str, Any]:
        """Return the facts for ``preflight.json``."""
        timing = self.timing
        return {
            "condition": self.cost.condition,
            "scene": self.cost.scene,
            "seconds": round(timing.seen.seconds(), 3),
            "frames": timing.frames,
            "dropped": timing.dropped,
            "period_ms": round(self.period_ms, 3),
            **timing.summary(),
            "margin_percent": self.margin_percent,
            "holds": self.holds(protocol),
            "flags": trial_flags(timing, protocol),
        }


def show_for(
    protocol: Protocol,
    cost: Cost,
    headset_for: Callable[[str, Any], Headset],
    renderer: StereoRenderer,
    load_scene: LoadScene,
    seconds: float,
    advance: Callable[..., object] = EMPTY,
) -> TimedShow:
    """Show a condition for `seconds` of display time, as an exposure does, and record nothing."""
    start = start_of(protocol, cost.scene, load_scene)
    headset = headset_for(protocol.view(cost.scene).scene, start.scene)
    renderer.begin(start.scene, protocol.condition(cost.condition, cost.scene))
    log, shown = FrameLog(_NoRows()), TimedShow(cost)
    log.start_trial(1)
    for frame, elapsed_s in _frames(headset, seconds, advance):
        for event in headset.take_events():
            if event.name == RATE_CHANGED:
                log.note_rate_change(event.detail)
        if frame.paused:
            headset.submit(frame, None)
            log.add_paused(frame, trial=1, session_s=elapsed_s)
            continue
        carried = _carried(frame, start, elapsed_s)
        rendered = renderer.render(carried, elapsed_s) if frame.should_render else None
        headset.submit(frame, rendered.eyes if rendered else None)
        log.add(frame, rendered, trial=1, session_s=elapsed_s)
        _look_at(shown, frame, headset)
    log.finish(renderer.drain(), renderer.drain_times() if log.times_gpu else ())
    shown.timing, shown.times_gpu = log.timing, log.times_gpu
    shown.timing.seen.end(seconds)
    return shown


def _frames(
    headset: Headset, seconds: float, advance: Callable[..., object]
) -> Iterator[tuple[Frame, float]]:
    """Yield frames with the display time since the first; a trace that begins again goes on."""
    passed_ns, before = 0, None
    for frame in headset.frames():
        if before is not None:
            step_ns = frame.predicted_display_time_ns - before.predicted_display_time_ns
            step_ns = step_ns if step_ns > 0 else before.period_ns
            passed_ns += step_ns
            advance(step_ns / 1e9)
        yield frame, passed_ns / 1e9
        before = frame
        if (passed_ns + frame.period_ns) / 1e9 >= seconds:
            return


def _carried(frame: Frame, start: StartPose, elapsed_s: float) -> Frame:
    if start.path is None:
        return frame
    return replace(frame, avatar_pose=start.path.moved(elapsed_s) @ frame.avatar_pose)


def _look_at(shown: TimedShow, frame: Frame, headset: Headset) -> None:
    shown.period_ms = frame.period_ns / 1e6
    if frame.head_tracked and frame.head_valid:
        shown.head_heights_m.append(float(frame.head_pose.position[1]))
    if isinstance(headset, HasInputs):
        hands = headset.inputs().hands
        shown.hands_seen = [
            seen + (hand.aim is not None)
            for seen, hand in zip(shown.hands_seen, hands, strict=True)
        ]
    shown.gaze_seen += frame.gaze is not None and frame.gaze.valid
