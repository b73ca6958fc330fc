"""Presents instructions: text, picture, sound."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.headset.sound import Sound, read_sound
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.session_steps import Instruction
from vrcomfort.protocol.timeline import InstructionStep, TrialPlace
from vrcomfort.respondent import InstructionContent
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_picture import (
    Painter,
    Picture,
    instruction_page,
    read_picture,
    room_for_picture,
)
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.operator_control import Redone, Skipped

SLICE_S = 0.1
"""Interval at which commands are handled during an instruction."""


@dataclass(frozen=True)
class Media:
    """The media of an instruction."""

    picture: Picture | None = None
    sound: Sound | None = None


def read_media(protocol: Protocol, instruction: Instruction) -> Media:
    """Return the picture and the sound of an instruction.

    Raises
    ------
    InputError
        If one cannot be read, or does not fit on the panel, or the words do not.
    """
    room_px = room_for_picture(instruction.text)
    if room_px[1] < 0:
        message = f"the text of instruction `{instruction.name}` does not fit on the panel"
        raise InputError(f"{message}; shorten it, or make two of it", file=protocol.file)
    picture, sound = instruction.picture, instruction.sound
    return Media(
        read_picture(protocol.media_file(picture), room_px) if picture else None,
        read_sound(protocol.media_file(sound)) if sound else None,
    )


def instruction_faults(protocol: Protocol) -> Iterator[InputError]:
    """Yield faults of instructions in any language: files, and texts that do not fit."""
    spoken = [protocol.spoken(language) for language in protocol.languages] or [protocol]
    seen = set()
    for each in [told for one in spoken for told in one.told]:
        key = each.text, each.picture, each.sound
        if key not in seen:
            seen.add(key)
            try:
                read_media(protocol, each)
            except InputError as error:
                yield error


def sounds_of(protocol: Protocol) -> dict[Path, Sound]:
    """Return the sounds that a participant of this language may hear."""
    files = {protocol.media_file(each.sound) for each in protocol.told if each.sound}
    return {file: read_sound(file) for file in sorted(files)}


class Instructor:
    """Tells the instructions of one session."""

    def __init__(self, context: SessionContext, events: EventLog) -> None:
        self._context = context
        self._events = events
        self._respondent = context.respondent
        self._operators = context.operators
        self._shown: InstructionContent | None = None

    def tell(self, step: InstructionStep) -> None:
        """Tell an instruction, again where an operator wants it so.

        Raises
        ------
        Withdrew
            If the participant stops. And what operators raise.
        """
        media = read_media(self._context.protocol, step.instruction)
        while self._tell(step, media) == "redone":
            pass

    def _tell(self, step: InstructionStep, media: Media) -> str:
        """Present an instruction once; return the cause of its end."""
        instruction = step.instruction
        speaker = self._context.speaker if media.sound else None
        content = _content_of(instruction, media, plays=speaker is not None)
        start_s = self._context.clock.now_s()
        ended = "interruption"
        self._operators.begin("instruction", self._words(step))
        try:
            if media.sound and speaker:
                speaker.play(media.sound)
            ended = self._until_over(content, instruction, step.place)
        except Skipped:
            ended = "experimenter"
        except Redone:
            ended = "redone"
        finally:
            if speaker:
                speaker.stop()
            passed_s = self._context.clock.now_s() - start_s
            what = _told(instruction, content, media, passed_s)
            detail = f"{instruction.name}: {what}; ended by {ended}"
            self._events.event("instruction", start_s, detail=detail)
            self._clear()
        self._respondent.leave()
        return ended

    def tell_until(
        self, content: InstructionContent, late_s: float | None, tell_late: Callable[[], None]
    ) -> str:
        """Tell something until the participant or the experimenter goes on; return which.

        Parameters
        ----------
        late_s
            Time of the session at which `tell_late` is called, once.
        """
        clock, start_s = self._context.clock, self._context.clock.now_s()
        try:
            while True:
                now_s = clock.now_s()
                if late_s is not None and now_s >= late_s - 1e-6:
                    late_s = None
                    tell_late()
                self._operators.look()
                self._show_beside(content)
                idle_s = self._respondent.read(content, now_s - start_s, may_go_on=True)
                if idle_s is None:
                    return "participant"
                self._pass(min(idle_s, math.inf if late_s is None else late_s - now_s))
        except Skipped:
            return "experimenter"
        finally:
            self._clear()

    def _clear(self) -> None:
        """Clear the panel that was shown beside the respondent."""
        if self._shown is not None and self._context.screen is not None:
            self._context.screen.show(None)
        self._shown = None

    def _words(self, step: InstructionStep) -> str:
        """Return the step's name for operators, with the text where they read it aloud."""
        words, text = step.words, step.instruction.text
        aloud = self._context.screen is None and text
        return f"{words}: {' '.join(text.split())}" if aloud else words

    def _until_over(
        self, content: InstructionContent, instruction: Instruction, place: TrialPlace
    ) -> str:
        """Let time pass until the participant goes on, or it is over; return which."""
        clock, start_s = self._context.clock, self._context.clock.now_s()
        least_s = max(instruction.min_s, content.sound_s or 0.0)
        most_s = instruction.max_s
        while True:
            elapsed_s = clock.now_s() - start_s
            if most_s is not None and elapsed_s >= most_s - 1e-6:
                return "time"
            self._operators.look()
            self._show_beside(content)
            self._events.tell("instruction", place, elapsed_s, least_s, content.name)
            may_go_on = elapsed_s >= least_s - 1e-6
            idle_s = self._respondent.read(content, elapsed_s, may_go_on=may_go_on)
            if idle_s is None:
                return "participant"
            due_s = [idle_s, *([] if may_go_on else [least_s - elapsed_s])]
            due_s += [] if most_s is None else [most_s - elapsed_s]
            self._pass(min(due_s))

    def _pass(self, duration_s: float) -> None:
        """Let a moment pass; none after a frame, which took its own time."""
        clock, screen = self._context.clock, self._context.screen
        if not duration_s:
            return
        if screen is not None and clock.is_real:
            screen.next_frame()
        else:
            clock.wait(min(duration_s, SLICE_S) if clock.is_real else duration_s)

    def _show_beside(self, content: InstructionContent) -> None:
        """Show the instruction in the headset for respondents without the panel."""
        screen = self._context.screen
        if screen is None or isinstance(self._respondent, PanelRespondent):
            return
        if self._shown is not content:
            self._shown = content
            page = instruction_page(content, self._context.protocol.words, ready=False)
            screen.show(Painter().draw(page, None))


def _content_of(instruction: Instruction, media: Media, *, plays: bool) -> InstructionContent:
    """Return the content to present: a text may stand in for a sound."""
    hides = instruction.show_text == "without_sound" and plays
    sound_s = media.sound.duration_s if media.sound and plays else None
    return InstructionContent(
        instruction.name, "" if hides else instruction.text, media.picture, sound_s
    )


def _told(
    instruction: Instruction, content: InstructionContent, media: Media, passed_s: float
) -> str:
    """Describe the presented media, with the played part of a sound."""
    told = ["text"] if content.text else []
    told += [] if content.picture is None else [f"picture {instruction.picture}"]
    if media.sound is not None and content.sound_s is None:
        told.append(f"sound {instruction.sound} not played: no sound device")
    elif media.sound is not None:
        whole_s = media.sound.duration_s
        told.append(f"sound {instruction.sound}, {min(passed_s, whole_s):.1f} of {whole_s:.1f} s")
    return ", ".join(told)
