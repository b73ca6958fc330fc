"""A small study for tests: a protocol, a headset that looks ahead, a renderer without pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tests.support.protocols import ASKED_AFTER_EACH, ASKED_BEFORE, explicit_order, protocol_text
from vrcomfort.csv_table import CsvTable
from vrcomfort.frame import FocusSample, Frame, HeadsetEvent
from vrcomfort.geometry import Fov, Pose, View
from vrcomfort.protocol import Condition, Protocol, load_protocol
from vrcomfort.questionnaire import Instrument
from vrcomfort.resources import data_folder
from vrcomfort.respondent import Exposure, Form, Heard, InstructionContent, Withdrew
from vrcomfort.respondent.base import Written

PROTOCOL = protocol_text(
    ASKED_BEFORE,
    ASKED_AFTER_EACH,
    '[[questionnaires]]\ntimepoint = "recovery"\nwhen = "session_end"\nwait_s = 60.0\n',
    '[ratings]\ninstrument = "fms"\nevery_s = 3.0\ntimeout_s = 2.0\nstop_at = 15\n',
    exposure_s=10.0,
    keys="training_s = 1.0\n",
    order=explicit_order(ab=[["plain", "blur"], ["blur", "plain"]]),
)


def tiny_protocol(folder: Path, text: str = PROTOCOL) -> Protocol:
    (folder / "room.glb").touch()
    file = folder / "tiny.toml"
    file.write_text(text, encoding="utf-8")
    return load_protocol(file)


def smoke_with(folder: Path, exposure_s: float) -> Path:
    """Write the smoke study with other exposures, rated at the same parts and felt alike."""
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    longer = exposure_s / 0.1
    for name, shipped, scale in (
        ("exposure_s", 0.1, longer),
        ("every_s", 0.04, longer),
        ("timeout_s", 0.03, longer),
        ("rate_per_min", 600.0, 1 / longer),
        ("recovery_min", 0.01, longer),
    ):
        assert text.count(f"{name} = {shipped}") == 1
        text = text.replace(f"{name} = {shipped}", f"{name} = {shipped * scale!r}")
    file = folder / "smoke.toml"
    file.write_text(text, encoding="utf-8")
    return file


def strict_about_gaze(folder: Path) -> Path:
    """Write a protocol whose `gaze_19` cannot be shown without an eye tracker.

    Nothing is validated, and simulated participants have no eyes.
    """
    text = (data_folder("protocols") / "mantiuk_2011.toml").read_text(encoding="utf-8")
    file = folder / "strict.toml"
    text = re.sub(r"\[gaze_validation\]\n(?:.+\n)*", "", text.replace("[simulation.eyes]", ""))
    file.write_text(text.replace('without_gaze = "nine_ray"', ""), encoding="utf-8")
    return file


def read_rows(file: Path) -> list[dict[str, str]]:
    """Return the rows of a recorded file, none of which may be half-written."""
    table = CsvTable.read(file, appended=True)
    assert table.warnings == ()
    return list(table.dicts())


@cache
def frame(index: int, *, period_ns: int = 100_000_000, time_ns: int | None = None) -> Frame:
    view = View(Pose(np.array([0.03, 1.6, 0.1 * index])), Fov(-0.8, 0.7, 0.9, -0.9))
    time_ns = index * period_ns if time_ns is None else time_ns
    return Frame(index, time_ns, period_ns, Pose(), (view, view), Pose(), True, index == 0)


@dataclass
class AheadHeadset:
    """Ten frames a second, for as long as `frames_left` lasts."""

    frames_left: int = 100_000
    interrupt_at: int | None = None
    submitted: int = 0
    name: str = "ahead"
    refresh_hz: float = 10.0
    image_size_px: tuple[int, int] = (4, 4)
    details: dict[str, str] = field(default_factory=dict)
    events: list[HeadsetEvent] = field(default_factory=list)

    def take_events(self) -> list[HeadsetEvent]:
        taken, self.events = self.events, []
        return taken

    def frames(self) -> Iterator[Frame]:
        for index in range(self.frames_left):
            if index == self.interrupt_at:
                raise KeyboardInterrupt
            yield frame(index)

    def submit(self, _frame: Frame, _eyes: Any) -> None:
        self.submitted += 1


def sample_of(frame_index: int) -> FocusSample:
    """Return the focus of a frame: eight rays meet something, one the sky."""
    return FocusSample(frame_index, 2.5, 3.5, np.array([*range(1, 9), 3e4]), np.arange(9) < 8)


@dataclass(frozen=True)
class Picture:
    focus_samples: tuple[FocusSample, ...]
    eyes: tuple[None, None] = (None, None)
    max_blur_px: float | None = 1.5
    gpu_times: tuple[Any, ...] | None = None
    hashed: bool = False
    image_hashes: tuple[Any, ...] = ()
    cpu_ms: float | None = None
    seeks_gaze: bool = False
    gaze_hits: tuple[Any, ...] = ()
    times_parts: bool = False
    part_times: tuple[Any, ...] = ()
    effect_centre: str | None = None


@dataclass
class LateFocus:
    """A renderer whose focus arrives three frames late, where the condition has any."""

    begun: list[tuple[Any, str]] = field(default_factory=list)
    shortened: tuple[str, ...] = ()

    def begin(self, scene: Any, condition: Condition) -> None:
        self.begun.append((scene, condition.name))
        self._focus = condition.depth_of_field is not None
        self._late: list[FocusSample] = []

    def render(self, frame: Frame, _scene_time_s: float) -> Picture:
        if self._focus:
            self._late.append(sample_of(frame.index))
        arrived = tuple(self._late[:-3])
        self._late = self._late[-3:]
        return Picture(arrived)

    def drain(self) -> list[FocusSample]:
        late, self._late = self._late, []
        return late

    def drain_hashes(self) -> tuple[Any, ...]:
        return ()

    def drain_gaze_hits(self) -> tuple[Any, ...]:
        return ()

    def drain_part_times(self) -> tuple[Any, ...]:
        return ()

    def clamps(self) -> tuple[str, ...]:
        return self.shortened if self._focus else ()


@dataclass
class Scripted:
    """Answers 1 everywhere; withdraws, interrupts or rates as told."""

    withdraw_at_s: float | None = None
    withdraw_at_item: str | None = None
    interrupt_at_item: str | None = None
    refuses: bool = False
    rates: int | None = 4
    name: str = "scripted"
    exposures: list[Exposure] = field(default_factory=list)
    perceived_s: list[float] = field(default_factory=list)
    told: list[InstructionContent] = field(default_factory=list)

    def start_session(self, session: int) -> None:
        self.session = session

    def start_exposure(self, exposure: Exposure) -> None:
        self.exposures.append(exposure)

    def update(self, elapsed_s: float) -> None:
        if self.withdraw_at_s is not None and elapsed_s >= self.withdraw_at_s:
            raise Withdrew("had enough")

    def end_exposure(self, elapsed_s: float) -> None:
        self.perceived_s.append(elapsed_s)

    def prompt(self, _instrument: Instrument, elapsed_s: float, _timeout_s: float) -> None:
        self.asked_s = elapsed_s

    def rating(self, elapsed_s: float) -> int | None:
        return self.rates if elapsed_s >= self.asked_s + 0.5 else None

    def resting(self, _left_s: float) -> bool:
        return False

    def rest(self, duration_s: float) -> None:
        self.rested_s = duration_s

    def read(
        self, content: InstructionContent, _elapsed_s: float, *, may_go_on: bool
    ) -> float | None:
        self.told.append(content)
        return None if may_go_on else 0.5

    def leave(self) -> None:
        pass

    def ask(self, form: Form, heard: Heard) -> None:
        if form.after_withdrawal and self.refuses:
            raise Withdrew("would not answer")
        for item in form.instrument.items:
            if form.timepoint == "post" and item.name == self.withdraw_at_item:
                raise Withdrew("stopped at a question")
            if form.timepoint == "post" and item.name == self.interrupt_at_item:
                raise KeyboardInterrupt
            heard(item.name, 1, 2.0)

    def write(self, _question: str) -> Written:
        return Written("", 0.0)

    def decide(self, _question: str) -> bool:
        return True
