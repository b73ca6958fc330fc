"""Steps of a session around its exposures: the tables of a protocol."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.frame import EYE_HEIGHT_M
from vrcomfort.protocol.conditions import Seconds
from vrcomfort.protocol.order import Trial
from vrcomfort.protocol.questions import Number, is_due, moment_problems
from vrcomfort.settings import KeyPath, Name, Problem, Settings, Word, did_you_mean, repeated


class Consent(Settings):
    """No session begins before the participant has consented in this version."""

    version: Name
    """Of the text; where it changes, everybody is asked again before their next session."""
    file: str = ""
    """The text, relative to the protocol file; its hash is recorded, so that no text changes
    under one version."""


When = Literal["session_start", "before_practice", "before_trial", "after_trial", "session_end"]
InstructionText = Annotated[str, Field(max_length=2000)]
MediaFile = Annotated[str, Field(max_length=200)]
MEDIA = ("picture", "sound")
"""Keys that name files."""


class InstructionWording(Settings):
    """An instruction in another language: `[text.de.instructions.welcome]`."""

    text: InstructionText = ""
    """Words on the panel; `""` where the `picture` says them."""
    picture: MediaFile = ""
    """PNG or JPEG file; without it, that of the usual language."""
    sound: MediaFile = ""
    """WAV file."""


class Instruction(Settings):
    """Something that participants are told, one at a time, before they go on."""

    name: Word
    """As `events.csv` has it."""
    when: When
    """`session_start` and `session_end`: before and after all questions; `before_trial` and
    `after_trial`: before their questions; `before_practice`: before each block of practice."""
    text: InstructionText = ""
    """Words on the panel, in the usual language."""
    picture: MediaFile = ""
    """PNG or JPEG file on the panel, relative to the protocol file."""
    sound: MediaFile = ""
    """WAV file that is played once."""
    show_text: Literal["always", "without_sound"] = "always"
    """`without_sound`: the text stands in for a sound that cannot be played."""
    sessions: tuple[Number, ...] = ()
    """Numbers of the sessions in which it is told; without it, all."""
    trials: tuple[Number, ...] = ()
    """Numbers, within the session, of the trials that it belongs to; without it, all."""
    min_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    """The participant cannot go on sooner, nor before the sound is over."""
    max_s: Annotated[float, Field(gt=0, le=3600)] | None = None
    """The session continues by itself then; without it, when the participant continues."""

    def is_due(self, when: str, session: int, trial: int | None) -> bool:
        """Return whether it is told at a moment."""
        return is_due(self, when, session, trial)

    def worded(self, wording: InstructionWording | None) -> Instruction:
        """Return it in a language that has a wording of its own."""
        if wording is None:
            return self
        # A picture may serve all languages; a sound is speech, and is never taken from another one.
        picture = wording.picture or self.picture
        return self.model_copy(
            update={"text": wording.text, "picture": picture, "sound": wording.sound}
        )

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield key and path of the files that it needs."""
        for key in MEDIA:
            if path := getattr(self, key):
                yield key, path


def instruction_problems(
    instructions: tuple[Instruction, ...], folder: Path | None
) -> Iterator[Problem]:
    """Yield faults of instructions.

    Parameters
    ----------
    folder
        Where their files are looked for; None: nowhere.
    """
    yield from repeated(("instructions",), [each.name for each in instructions])
    yield from moment_problems("instructions", instructions)
    for index, each in enumerate(instructions):
        path: KeyPath = ("instructions", index)
        yield from _missing_files(path, each.files(), folder)
        if not (each.text or each.picture or each.sound):
            message = f"`{each.name}` tells nothing; give it a `text`, a `picture` or a `sound`"
            yield Problem((*path, "name"), message)
        if each.max_s is not None and each.max_s < each.min_s:
            yield Problem((*path, "max_s"), "`max_s` is less than `min_s`; make it longer")
        if each.show_text == "without_sound" and not (each.text and each.sound):
            message = "`show_text` needs a `text` and a `sound`; remove it or add them"
            yield Problem((*path, "show_text"), message)


def _missing_files(
    path: KeyPath, files: Iterable[tuple[str, str]], folder: Path | None
) -> Iterator[Problem]:
    for key, name in files:
        if folder is not None and not (folder / name).is_file():
            yield Problem((*path, key), f"there is no {key} file {folder / name}")


def wording_problems(
    language: str,
    usual: bool,
    given: Mapping[str, InstructionWording],
    instructions: tuple[Instruction, ...],
    folder: Path | None,
) -> Iterator[tuple[KeyPath, str]]:
    """Yield paths below the language's table, and the faults of its instructions.

    Parameters
    ----------
    usual
        Whether it is the language of `[[instructions]]` itself.
    """
    by_name = {each.name: each for each in instructions}
    for name, wording in given.items():
        here: KeyPath = ("instructions", name)
        if name not in by_name:
            yield here, f"there is no instruction `{name}`; {did_you_mean(name, by_name)}"
            continue
        if usual:
            yield here, f"`{language}` is the usual language: its words stand in [[instructions]]"
        files = Instruction.files(by_name[name].worded(wording))
        for problem in _missing_files(here, files, folder):
            yield problem.path, problem.message
    for each in instructions if not usual else ():
        wording = given.get(each.name, InstructionWording())
        lacks = [
            key for key in ("text", "sound") if getattr(each, key) and not getattr(wording, key)
        ]
        if wording.picture and "text" in wording.model_fields_set:
            lacks = [key for key in lacks if key != "text"]
        if lacks:
            what = f"instruction `{each.name}` lacks its {' and its '.join(lacks)} in `{language}`"
            yield (), f"{what}; write it into [text.{language}.instructions.{each.name}]"


class Posture(Settings):
    """The height of the eyes is measured; without this table nothing is."""

    mode: Literal["seated", "standing"]
    """How participants are meant to be; they are asked to, and it is recorded."""
    eyes: Literal["scene", "own"] = "scene"
    """`scene`: the floor of the scene is moved, so that everybody sees from `eye_height_m`. `own`:
    from their own height over the floor, which is only recorded."""
    eye_height_m: Annotated[float, Field(ge=0.3, le=3)] = EYE_HEIGHT_M
    """Over the floor of the scene, with `eyes = "scene"`."""
    measure_s: Annotated[float, Field(ge=0.2, le=30)] = 1.0
    """For how long it is measured; the median counts."""
    settle_s: Annotated[float, Field(ge=0, le=30)] = 2.0
    """Time before that, in which people sit or stand up straight."""
    after_breaks: bool = True
    """Measured again after breaks, as well as when a session begins."""

    @model_validator(mode="after")
    def _height_does_something(self) -> Self:
        if self.eyes == "own" and "eye_height_m" in self.model_fields_set:
            message = '`eye_height_m` does nothing with eyes = "own"; remove it or change that'
            raise PydanticCustomError("posture_height", message)
        return self


Angle = Annotated[float, Field(ge=-60, le=60)]
Metres = Annotated[float, Field(ge=0.2, le=1000)]
Point = tuple[Angle, Angle, Metres]


class GazeValidation(Settings):
    """Points that participants look at before the exposures: how far off the eye tracker is.

    The calibration is the headset's own; this measures what it is worth, as Mantiuk et al. (2011)
    did, who ended sessions with an error above 1.5 degrees.
    """

    points: Annotated[tuple[Point, ...], Field(min_length=1, max_length=50)] = (
        (0.0, 0.0, 1.0),
        (-10.0, 0.0, 1.0),
        (10.0, 0.0, 1.0),
        (0.0, 8.0, 1.0),
        (0.0, -8.0, 1.0),
        (-7.0, 6.0, 3.0),
        (7.0, 6.0, 3.0),
        (-7.0, -6.0, 3.0),
        (7.0, -6.0, 3.0),
    )
    """[degrees to the right, degrees up, metres] from where the head looks as each appears."""
    each_s: Annotated[float, Field(ge=0.3, le=60)] = 1.5
    """How long each is shown."""
    settle_s: Annotated[float, Field(ge=0, le=30)] = 0.7
    """After it appeared: time in which the eyes are on their way, and nothing counts."""
    diameter_deg: Annotated[float, Field(ge=0.1, le=5)] = 0.5
    """Angle at which a point is seen."""
    limit_deg: Annotated[float, Field(gt=0, le=45)] = 1.5
    """Largest mean error over the points that is good enough."""
    attempts: Annotated[int, Field(ge=1, le=10)] = 2
    """Number of attempts in all, while the error is above the limit."""
    above: Literal["end_session", "end_study", "note"] = "end_session"
    """Consequence of an error above the limit in the last attempt."""
    after_breaks: bool = True
    """Again after each break between exposures: the headset may have been off."""

    @model_validator(mode="after")
    def _settles(self) -> Self:
        if self.settle_s >= self.each_s:
            message = "nothing of a point would count: make `settle_s` shorter than `each_s`"
            raise PydanticCustomError("gaze_settle", message)
        return self


Count = Annotated[int, Field(ge=1, le=100)]


class Practice(Settings):
    """A block of practice, before a trial. It is in `practice.csv`, and in no other analysis."""

    name: Word
    """As `practice.csv` has it."""
    before_trial: Annotated[int, Field(ge=1, le=1000)] = 1
    """Number of the trial, within the session, that it comes before."""
    sessions: tuple[Annotated[int, Field(ge=1, le=1000)], ...] = ()
    """Numbers of the sessions that have it; without it, all."""
    trials: tuple[Trial, ...] = ()
    """Trials of practice, in this order."""
    draw: Count | None = None
    """Instead of `trials`: a number of the session's own trials, drawn with the study's seed."""
    exposure_s: Seconds | None = None
    """How long each is shown; without it, as long as in the study."""
    score_at_least: Annotated[float, Field(ge=-1e6, le=1e6)] | None = None
    """The criterion: mean score of the block's tasks (docs/tasks.md)."""
    hits_at_least: Annotated[int, Field(ge=1, le=100_000)] | None = None
    """The criterion: hits of the block's tasks, added up."""
    at_most: Count = 1
    """Repetitions of the block, in all, until its criterion is met."""
    otherwise: Literal["go_on", "session", "study"] = "go_on"
    """Where it is still not met: the trial comes, or the session, or the participant's study,
    ends."""

    def is_due(self, session: int, trial: int) -> bool:
        """Return whether it comes before a trial."""
        return trial == self.before_trial and (not self.sessions or session in self.sessions)

    @property
    def has_criterion(self) -> bool:
        """Return whether anything must be reached."""
        return self.score_at_least is not None or self.hits_at_least is not None

    def met(self, scores: list[float], hits: int) -> bool | None:
        """Return whether a block was good enough; None without a criterion.

        Parameters
        ----------
        scores
            Of its tasks, as far as they have one.
        hits
            Of all of them.
        """
        if not self.has_criterion:
            return None
        if self.hits_at_least is not None and hits < self.hits_at_least:
            return False
        wanted = self.score_at_least
        return wanted is None or (bool(scores) and sum(scores) / len(scores) >= wanted)


Duration = Annotated[float, Field(ge=0, le=86_400)]


class Breaks(Settings):
    """A break is over when the participant, or the experimenter, goes on."""

    min_s: Duration = 0.0
    """Minimum length; only the experimenter can go on sooner, which is recorded."""
    max_s: Duration | None = None
    """After it the experimenter is told, which is recorded; the break goes on."""
    after_trials: tuple[Annotated[int, Field(ge=1, le=1000)], ...] = ()
    """Numbers of the trials of a session after which there is one; without it, after each but the
    last."""

    def is_due(self, trial: int) -> bool:
        """Return whether there is one after a trial."""
        return not self.after_trials or trial in self.after_trials


def break_problems(breaks: Breaks | None, break_s: float) -> Iterator[Problem]:
    """Yield faults of [breaks]."""
    if breaks is None:
        return
    if break_s:
        message = "`break_s` is a rest of a fixed length, and [breaks] say how long theirs are"
        yield Problem(("break_s",), f"{message}; remove one of the two")
    if breaks.max_s is not None and breaks.max_s < breaks.min_s:
        yield Problem(("breaks", "max_s"), "`max_s` is less than `min_s`; make it longer")
