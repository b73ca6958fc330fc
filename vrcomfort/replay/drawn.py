"""Draws the frames of a recorded session again, in order and with the time that each was seen.

Hashes of the images tell whether they are those that the participant saw.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from vrcomfort.frame import DROPPED_INTERVAL_PERIODS, Frame
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition
from vrcomfort.protocol.adjustments import adjusted
from vrcomfort.records import Machine
from vrcomfort.render.display import PatchLight
from vrcomfort.replay.recorded import RecordedExposure, RecordedSession
from vrcomfort.scene.markers import Markers

if TYPE_CHECKING:
    from vrcomfort.render.pipeline import StereoRenderer


@dataclass
class Comparison:
    """How many of the recorded hashes the replay's images have.

    Attributes
    ----------
    compared, equal
        Frames of which a hash is recorded and that were drawn again; those whose both images are
        equal to the last bit.
    """

    compared: int = 0
    equal: int = 0

    def add(self, recorded: tuple[str, str], now: tuple[str, str]) -> bool:
        """Compare one frame; return whether it is equal."""
        same = recorded == now
        self.compared += 1
        self.equal += same
        return same

    @property
    def sentence(self) -> str:
        """Say it."""
        if not self.compared:
            return "no recorded image was among those drawn; whether they are equal is not known"
        return f"{self.equal} of {self.compared} recorded images are equal to the last bit"


def differences(manifest: Mapping[str, Any], machine: Machine) -> Iterator[str]:
    """Yield changes since the session was run that may change images."""
    for name in ("gpu", "driver"):
        then, now = manifest.get(name) or "", getattr(machine, name)
        if then and then != now:
            yield f"the {name} was {then}, and is {now}"
    then = manifest.get("shaders") or {}
    changed = sorted(name for name in then if machine.shaders.get(name) != then[name])
    if changed:
        first = ", ".join(changed[:3]) + (", …" if len(changed) > 3 else "")
        yield f"{len(changed)} of {len(then)} shaders have changed ({first})"


_EPSILON_S = 1e-6
"""Of session times in files."""


@dataclass(frozen=True)
class ReplaySelection:
    """The selected part of a session, and its conditions.

    Parameters
    ----------
    trial
        Only this one; 0 is training, None is all that was seen.
    from_s, to_s
        Only frames of this time of the session.
    instead
        Condition of the session → the one that is drawn in its place.
    beside
        The condition that is drawn beside it, from the same frames.
    """

    trial: int | None = None
    from_s: float = float("-inf")
    to_s: float = float("inf")
    instead: Mapping[str, Condition] = field(default_factory=dict)
    beside: Condition | None = None

    def wants(self, trial: int, session_s: float) -> bool:
        """Return whether a frame is to be shown."""
        return self.trial in {None, trial} and self.from_s <= session_s <= self.to_s


@dataclass(frozen=True, eq=False)
class DrawnFrame:
    """One frame that was drawn again.

    Parameters
    ----------
    row
        Of ``frames.csv``, from 0.
    video_s
        When it is seen in the replay; what was dropped before it is time, too.
    trial
        0 in training.
    eyes, beside
        Both eyes' textures, valid until the next frame; None without another condition.
    focus_m
        After the refocus law, as it was found when the frame was drawn again; None where nothing
        needs a focus. It is that of some frames before.
    equal
        Whether both images have the recorded hashes; None where none are recorded.
    """

    row: int
    frame: Frame
    exposure: RecordedExposure
    trial: int
    session_s: float
    video_s: float
    missed_refreshes: int
    eyes: tuple[Any, Any]
    beside: tuple[Any, Any] | None
    focus_m: float | None
    equal: bool | None


def replay(
    session: RecordedSession,
    selection: ReplaySelection,
    *,
    drawer: StereoRenderer,
    second: StereoRenderer | None,
    load_scene: Callable[[str], Any],
    size_px: tuple[int, int],
    comparison: Comparison,
) -> Iterator[DrawnFrame]:
    """Yield the frames of a session that are wished for, drawn again.

    Each exposure is drawn from its start, also where only its end is shown: focus, and what moves,
    have a history.

    Parameters
    ----------
    second
        Draws `selection.beside`.
    comparison
        Is told of each frame whose hashes are recorded, also of those that are not shown.
    """
    end_s = 0.0
    for exposure in session.exposures:
        last = last_wanted(session, exposure, selection)
        if last is None:
            continue
        scene = load_scene(exposure.scene)
        balls = _Balls(exposure, scene) if exposure.balls else None
        drawn_scene = scene if balls is None else balls.scene
        name = exposure.condition
        condition = selection.instead.get(name) or session.condition(name)
        condition = condition.in_scene(exposure.scene)
        dial = _Dial(session, exposure, condition) if condition.name == name else None
        drawer.begin(drawn_scene, dial.built_for if dial else condition)
        if second is not None and selection.beside is not None:
            second.begin(drawn_scene, selection.beside.in_scene(exposure.scene))
        film = _Film(session, exposure, selection, size_px, comparison, balls, dial)
        for drawn in film.frames(drawer, second if selection.beside else None, scene, last):
            yield replace(drawn, video_s=drawn.video_s + end_s)
        end_s += film.length_s


def last_wanted(
    session: RecordedSession, exposure: RecordedExposure, selection: ReplaySelection
) -> int | None:
    """Return the last row of an exposure that is to be shown; None where none is."""
    for row in reversed(range(exposure.first, exposure.end)):
        trial = exposure.trial if row >= exposure.shown else 0
        if selection.wants(trial, float(session.session_s[row])):
            return row
    return None


class _Balls:
    """The balls of an exposure's task, drawn as they were at each time."""

    def __init__(self, exposure: RecordedExposure, scene: Any) -> None:
        colors = {ball.ball: ball.color for _, ball in exposure.balls}
        black = 0.0, 0.0, 0.0
        self._markers = Markers(scene, [colors.get(k, black) for k in range(1, max(colors) + 1)])
        self._coming = deque(exposure.balls)
        self.scene = self._markers.scene

    def show(self, time_ns: int) -> None:
        """Draw them as they were in the frame of a time, and not before it."""
        while self._coming and self._coming[0][0] <= time_ns:
            self._markers.show(self._coming.popleft()[1])


class _Dial:
    """The adjustment of an exposure, turned as it was; in most there is none."""

    def __init__(
        self, session: RecordedSession, exposure: RecordedExposure, condition: Condition
    ) -> None:
        self._condition, self._coming = condition, deque(exposure.turned)
        self.built_for, self._begins = condition, True
        if self._coming:
            first = self._coming[0]
            self.built_for = adjusted(condition, first.setting, session.highest(first.dial))

    def turn(self, drawer: StereoRenderer, session_s: float) -> None:
        """Draw as the dial stood in a frame; before the exposure it stands where it begins."""
        turned = None
        while self._coming and (self._coming[0].since_s <= session_s + _EPSILON_S or self._begins):
            turned, self._begins = self._coming.popleft(), False
        if turned is not None:
            drawer.adjust(adjusted(self._condition, turned.setting, turned.value))


@dataclass
class _Film:
    """The frames of one exposure, and their time in the replay."""

    session: RecordedSession
    exposure: RecordedExposure
    selection: ReplaySelection
    size_px: tuple[int, int]
    comparison: Comparison
    balls: _Balls | None
    dial: _Dial | None
    length_s: float = 0.0
    _shown_ns: int | None = None
    _focus_m: float | None = None

    def frames(
        self, drawer: StereoRenderer, second: StereoRenderer | None, scene: Any, last: int
    ) -> Iterator[DrawnFrame]:
        exposure, session = self.exposure, self.session
        headset = PlaybackHeadset(
            session.trace.between(exposure.first, last + 1),
            image_size_px=self.size_px,
            spawn=scene.spawn,
            loop=False,
        )
        start_ns = int(session.trace.time_ns[exposure.first])
        cut = snap = False
        patch = session.photodiode
        light = None if patch is None else PatchLight(patch)
        for row, frame in enumerate(headset.frames(), start=exposure.first):
            trial = exposure.trial if row >= exposure.shown else 0
            session_s = float(session.session_s[row])
            if self.balls is not None:
                self.balls.show(int(session.trace.time_ns[row]))
            if self.dial is not None:
                self.dial.turn(drawer, session_s)
            wanted = self.selection.wants(trial, session_s)
            video_s = self._video_s(row, frame) if wanted else 0.0
            if not session.drawn[row]:  # the picture before stood; jumps are seen with the next
                cut, snap = cut or frame.discontinuity, snap or frame.snap_turn
                continue
            frame = replace(  # noqa: PLW2901
                frame,
                discontinuity=frame.discontinuity or cut,
                snap_turn=frame.snap_turn or snap,
                patch=None if light is None else _is_white(light, frame, trial),
            )
            cut = snap = False
            scene_time_s = (frame.predicted_display_time_ns - start_ns) / 1e9
            rendered = drawer.render(frame, scene_time_s)
            other = second.render(frame, scene_time_s).eyes if second else None
            for sample in rendered.focus_samples:
                self._focus_m = float(sample.focus_m)
            equal = self._compare(row, frame, drawer)
            if wanted:
                yield DrawnFrame(
                    row=row,
                    frame=frame,
                    exposure=exposure,
                    trial=trial,
                    session_s=session_s,
                    video_s=video_s,
                    missed_refreshes=int(session.missed_refreshes[row]),
                    eyes=rendered.eyes,
                    beside=other,
                    focus_m=self._focus_m,
                    equal=equal,
                )

    def _compare(self, row: int, frame: Frame, drawer: StereoRenderer) -> bool | None:
        recorded = self.session.hashes.get(int(self.session.trace.time_ns[row]))
        if recorded is None or self.size_px != self.session.size_px:
            return None
        _, left, right = drawer.hash_now(frame.index)
        return self.comparison.add(recorded, (left, right))

    def _video_s(self, row: int, frame: Frame) -> float:
        """Return the frame's time in the video: dropped frames count, hidden ones do not."""
        now_ns, period_ns = frame.predicted_display_time_ns, frame.period_ns
        if self._shown_ns is None:
            video_s = 0.0
        else:
            passed_ns = now_ns - self._shown_ns
            hidden = (
                passed_ns > DROPPED_INTERVAL_PERIODS * period_ns
                and not self.session.missed_refreshes[row]
            )
            stood_ns = period_ns if hidden or frame.discontinuity else passed_ns
            video_s = self.length_s + (stood_ns - period_ns) / 1e9
        self._shown_ns = now_ns
        self.length_s = video_s + period_ns / 1e9
        return video_s


def _is_white(light: PatchLight, frame: Frame, trial: int) -> bool:
    return trial > 0 and light.of_next(frame.predicted_display_time_ns)
