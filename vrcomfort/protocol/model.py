"""The frozen tables of a protocol file, with every default resolved; and the trials of a study."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr, field_validator

from vrcomfort.errors import InputError
from vrcomfort.files import sha256_of
from vrcomfort.protocol.adjustments import Adjustment, Slider
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.factors import CrossedFactor
from vrcomfort.protocol.order import (
    NO_TASK,
    Allocation,
    Covariate,
    Group,
    Order,
    Part,
    Trial,
    orders_of,
)
from vrcomfort.protocol.questions import (
    Ask,
    FreeText,
    Ratings,
    Rest,
    Screening,
    Stopping,
    Unfocused,
    is_due,
)
from vrcomfort.protocol.session_steps import (
    Breaks,
    Consent,
    GazeValidation,
    Instruction,
    Posture,
    Practice,
)
from vrcomfort.protocol.simulation import Simulation
from vrcomfort.protocol.texts import LanguageTable, Words, words_of
from vrcomfort.protocol.viewing import (
    Answering,
    HeadsetSettings,
    LocomotionSettings,
    Percent,
    Photodiode,
    SceneView,
    SeenTimeLimits,
    Visibility,
)
from vrcomfort.questionnaire import Instrument, shipped_instruments
from vrcomfort.settings import KeyPath, Name, Problem, Settings, Word
from vrcomfort.settings.include import Source
from vrcomfort.settings.schema import or_one_table
from vrcomfort.tasks import AnyTask, TaskSettings


class Protocol(Settings):
    """A study: its stimuli, their order, its questions and their times."""

    include: tuple[str, ...] = ()
    """TOML files, relative to this one, that come before it: tables are joined, lists of tables put
    one after the other, and of other keys the last one counts."""
    name: Name
    """Of the study: letters, digits, - and _; study folders keep it."""
    title: str
    """In words."""
    citation: str = ""
    """The paper whose study this is."""
    participants: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """Planned number of participants."""
    exposure_s: Annotated[float, Field(ge=0.001, le=14_400)]
    """How long a trial is, up to four hours; views may have lengths of their own."""
    training_s: Annotated[float, Field(ge=0, le=14_400)] = 0.0
    """Time to learn the controls, before the first exposure of each session, in its scene."""
    practice: tuple[Practice, ...] = ()
    """Practice before trials of the study."""
    break_s: Rest = 0.0
    """Rest between two exposures of a session."""
    breaks: Breaks | None = None
    """Rests between exposures that participants end themselves, instead of `break_s`."""
    hours_between_sessions: Annotated[float, Field(ge=0, le=8760)] = 0.0
    """From the end of a participant's session to the beginning of the next, at least; `run` refuses
    to begin it sooner. Simulated participants have waited."""
    max_dropped_percent: Percent = 5.0
    """Share of dropped frames above which a trial is flagged; its data stay."""
    flag_above_percent: SeenTimeLimits = SeenTimeLimits()
    """Shares of an exposure's time above which it is flagged; its data stay."""
    resumed_questions_within_s: Rest = 600.0
    """Time after the last exposure within which an interrupted session first asks the questions
    that were open; later, those items are missed."""
    unfocused: Unfocused = "pause"
    """While a menu of the headset's is in front, the participant sees the scene and cannot stop:
    `pause` counts no exposure then, `flag` counts it and flags the trial."""
    scenes: Annotated[tuple[str, ...], Field(min_length=1)]
    """Shipped scenes by name, .glb/.gltf files relative to the protocol file, or names of views."""
    views: tuple[SceneView, ...] = ()
    """Scenes from a place, along a path, or for a time of their own."""
    conditions: tuple[Condition, ...] = ()
    """Ways of rendering; or `factors`."""
    factors: tuple[CrossedFactor, ...] = ()
    """Instead of conditions: every level of each with every level of the others."""
    order: Order
    """Rule, sessions and sequences of trials."""
    parts: tuple[Part, ...] = ()
    """Parts with orders of their own, for `rule = "parts"`."""
    groups: tuple[Group, ...] = ()
    """Levels of a between-subject factor."""
    covariates: tuple[Covariate, ...] = ()
    """Facts that are entered on each participant at the enrolment."""
    consent: Consent | None = None
    """Text that participants must have consented to; no consent is asked for without it."""
    screening: tuple[Screening, ...] = ()
    """Rules on whom the experimenter is told of before they are exposed."""
    allocation: Allocation | None = None
    """How people come into groups; without it, `permuted_blocks` of the whole study."""
    languages: tuple[Word, ...] = ()
    """In which participants can be asked (`run --language`), the usual one first: `["en", "de"]`.
    Without it, each instrument is asked in its own."""
    text: dict[str, LanguageTable] = Field(default_factory=dict)
    """Words of other languages, or other words: `[text.fr]`."""
    instructions: tuple[Instruction, ...] = ()
    """Instructions to participants, and their times."""
    questionnaires: tuple[Ask, ...] = ()
    """Questionnaires, and their times. A study without any has ratings or tasks."""
    free_texts: tuple[FreeText, ...] = ()
    """Questions that are answered in one's own words; answers may identify the participant."""
    ratings: Annotated[tuple[Ratings, ...], Field(json_schema_extra=or_one_table)] = ()
    """Questions that are asked again and again during exposure, one at a time: where two are due,
    the second waits for the answer to the first."""
    tasks: tuple[AnyTask, ...] = ()
    """Tasks of participants during an exposure (docs/tasks.md)."""
    gaze_validation: GazeValidation | None = None
    """How the eye tracker is validated; not at all without it."""
    task: Word | None = None
    """Name of the task of every exposure whose trial and condition name none."""
    stop: Stopping = Stopping()
    """Rules that end a session, or a participant's study."""
    sliders: tuple[Slider, ...] = ()
    """Ratings that are given all the time (docs/ratings.md)."""
    adjustments: tuple[Adjustment, ...] = ()
    """Settings that participants adjust themselves while they look (docs/adjustment.md)."""
    exposure_ends: Literal["time", "task", "adjustment"] = "time"
    """`task`: an exposure is over when its task is done, `adjustment`: when its adjustment is
    confirmed; at the latest after its time."""
    headset: HeadsetSettings = HeadsetSettings()
    """Headset that the study is meant for."""
    answering: Answering = Answering()
    """How they answer in it."""
    photodiode: Photodiode | None = None
    """A patch by which a photodiode sees when frames are seen; none without it."""
    visibility: Visibility = Visibility()
    """Details that need not be visible or distinguishable."""
    posture: Posture | None = None
    """Seated or standing, with the height of the eyes measured; not at all without it."""
    locomotion: LocomotionSettings = LocomotionSettings()
    """How participants move."""
    simulation: Simulation = Simulation()
    """How simulated participants feel."""

    @field_validator("ratings", mode="before")
    @classmethod
    def _one_table(cls, value: Any) -> Any:
        """Take the single [ratings] table of earlier protocols."""
        return (value,) if isinstance(value, dict) else value

    # Private, for they are no keys of a protocol: `load.parse_protocol` sets them once all named
    # files are found, `spoken` and `with_task_code` set them in copies.
    _source: Source | None = PrivateAttr(default=None)
    _file: Path | None = PrivateAttr(default=None)
    _language: str | None = PrivateAttr(default=None)
    _instruments: dict[str, Instrument] = PrivateAttr(default_factory=dict)
    _tasks: dict[str, TaskSettings] = PrivateAttr(default_factory=dict)
    _task_code: dict[str, str] = PrivateAttr(default_factory=dict)
    _adjustments: dict[str, Adjustment] = PrivateAttr(default_factory=dict)

    def instrument(self, name: str) -> Instrument:
        """Return an instrument that this asks, by its name; loading made sure that it is there."""
        return self._instruments[name]

    def form(self, ask: Ask) -> Instrument:
        """Return the instrument of a questionnaire with its asked items, in its language."""
        whole = self.instrument(ask.instrument)
        worded = whole.in_language(ask.language or self._language or whole.language) or whole
        return replace(worded, items=worded.asked)

    def writes(self, when: str, session: int, trial: int | None) -> Iterator[FreeText]:
        """Yield the free texts of a moment, in the participant's language."""
        table = self.text.get(self._language or "")
        wordings = table.free_texts if table else {}
        for each in self.free_texts:
            if is_due(each, when, session, trial):
                yield each.model_copy(update={"text": wordings.get(each.name, each.text)})

    def task_of(self, trial: Trial) -> TaskSettings | None:
        """Return the task of a trial: its own, its condition's, or the protocol's."""
        name = trial.task or self.condition(trial.condition).task or self.task
        return None if name in (None, NO_TASK) else self._tasks[name]

    def adjustment_in(self, condition: str) -> Adjustment | None:
        """Return the adjustment in exposures to a condition."""
        return self._adjustments.get(condition)

    def slider_in(self, condition: str) -> Slider | None:
        """Return the slider in exposures to a condition."""
        there = (each for each in self.sliders if condition in (each.conditions or (condition,)))
        return next(there, None)

    @property
    def all_rated(self) -> tuple[Ratings | Slider, ...]:
        """Return all that is rated during exposure: now and then, and all the time."""
        return (*self.ratings, *self.sliders)

    @property
    def language(self) -> str | None:
        """Return the language that was chosen for a participant; None: each instrument's own."""
        return self._language

    @property
    def words(self) -> Words:
        """Return the panel's words in the participant's language."""
        return words_of(self._language or "en", self.text)

    @property
    def wordings(self) -> list[dict[str, str]]:
        """Return each instrument's language, and the origin of its wording."""
        found: list[dict[str, str]] = []
        forms = [self.form(ask) for ask in self.questionnaires]
        for form in [*forms, *(self.rated(each) for each in self.all_rated)]:
            entry = {"instrument": form.name, "language": form.language}
            entry["source"] = self.instrument(form.name).wording_source(form.language)
            found += [] if entry in found else [entry]
        return found

    def spoken(self, language: str | None) -> Protocol:
        """Return the protocol as a participant of a language is asked; None: in the usual one.

        Raises
        ------
        InputError
            If the protocol has no such language.
        """
        if language is None and not self.languages:
            return self
        chosen = language or self.languages[0]
        if chosen not in self.languages:
            known = ", ".join(self.languages) or "none: write `languages`"
            message = f"protocol {self.name} is not asked in `{chosen}`; it has {known}"
            raise InputError(message, file=self._file)
        spoken = self.model_copy()
        spoken._language = chosen
        return spoken

    def rated(self, ratings: Ratings | Slider) -> Instrument:
        """Return the instrument of a rating in the participant's language."""
        whole = self.instrument(ratings.instrument)
        return whole.in_language(self._language or whole.language) or whole

    @property
    def own_instruments(self) -> dict[str, str]:
        """Return name → TOML text of the instruments that are the lab's."""
        shipped = shipped_instruments()
        return {n: each.text for n, each in self._instruments.items() if n not in shipped}

    @property
    def toml(self) -> str:
        """Return the TOML text that this was read from, with all that it includes."""
        return self._source.text if self._source else ""

    @property
    def included(self) -> dict[str, str]:
        """Return file → hash of all that was put together; nothing where it is one file."""
        files = self._source.parts if self._source else []
        return {str(each.file): each.sha256 for each in files} if len(files) > 1 else {}

    @property
    def file(self) -> Path | None:
        """Return the file that this was read from."""
        return self._file

    @property
    def sha256(self) -> str:
        """Return the hash of the text, by which two runs of the same protocol are known."""
        return hashlib.sha256(self.toml.encode()).hexdigest()

    def fault(self, path: KeyPath, message: str) -> InputError:
        """Return the error for something wrong at a key of the text."""
        if self._source is None:
            return InputError(message, file=self._file)
        _, file, line, column = self._source.place(path)
        return InputError(message, file=file, line=line, column=column)

    def first_fault(self, found: Sequence[Problem]) -> InputError:
        """Return the error of the first fault in the text; the others are its `others`."""
        if self._source is None:
            return self.fault(found[0].path, found[0].message)
        return self._source.first_problem(found)

    def shown_s(self, shortened_s: float | None) -> float:
        """Return how long an exposure is shown at most: as the protocol says, or shortened.

        Raises
        ------
        InputError
            If `shortened_s` is longer, or no time: what people were told is never exceeded.
        """
        if shortened_s is None:
            return self.longest_s
        if not 0 < shortened_s <= self.longest_s:
            raise InputError(
                f"an exposure of {shortened_s:g} s cannot be shown: protocol {self.name} has "
                f"exposures of {self.longest_s:g} s, which can only be shortened; for longer ones "
                "change exposure_s in a copy of the protocol",
                file=self._file,
            )
        return shortened_s

    def length_s(self, scene: str) -> float:
        """Return how long an exposure to a scene, or to a view, lasts."""
        return self.view(scene).exposure_s or self.exposure_s

    @property
    def longest_s(self) -> float:
        """Return the length of the longest exposure."""
        return max(self.length_s(scene) for scene in self.scenes)

    def view(self, scene: str) -> SceneView:
        """Return the view of that name; of a whole scene, one that changes nothing."""
        named = (view for view in self.views if view.name == scene)
        return next(named, SceneView.model_construct(name=scene, scene=scene))

    def condition(self, name: str, scene: str | None = None) -> Condition:
        """Return the condition called `name`; loading made sure that trials name real ones.

        Parameters
        ----------
        scene
            Of a trial: the condition as it is there.
        """
        found = next(condition for condition in self.conditions if condition.name == name)
        return found if scene is None else found.in_scene(scene)

    def asks(self, when: str, session: int, trial: int | None) -> Iterator[Ask]:
        """Yield the questionnaires asked at a moment, in the file's order."""
        return (ask for ask in self.questionnaires if is_due(ask, when, session, trial))

    def tells(self, when: str, session: int, trial: int | None) -> Iterator[Instruction]:
        """Yield the instructions at a moment, in the participant's language."""
        return (each for each in self.told if each.is_due(when, session, trial))

    @property
    def told(self) -> list[Instruction]:
        """Return all instructions in the participant's language."""
        table = self.text.get(self._language or "")
        wordings = table.instructions if table else {}
        return [each.worded(wordings.get(each.name)) for each in self.instructions]

    @property
    def media(self) -> dict[str, str]:
        """Return file → SHA-256 of the pictures and sounds of instructions, as they are now.

        Raises
        ------
        InputError
            If one cannot be read.
        """
        hashes = {}
        for name in sorted({name for each in self.told for _, name in each.files()}):
            file = self.media_file(name)
            try:
                hashes[name] = sha256_of(file)
            except OSError as error:
                message = f"this cannot be read: {error.strerror or error}"
                raise InputError(message, file=file) from error
        return hashes

    def media_file(self, name: str) -> Path:
        """Return the file of a picture or a sound, which is beside the protocol file."""
        return self._file.parent / name if self._file else Path(name)

    @property
    def task_code(self) -> dict[str, str]:
        """Return file → SHA-256 of the own tasks that have run; see `with_task_code`."""
        return dict(self._task_code)

    def scene_source(self, scene: str) -> str:
        """Return a scene's source for the loader: a shipped name, or a path beside the protocol."""
        scene = self.view(scene).scene
        is_file = scene.endswith((".glb", ".gltf"))
        return str(self._file.parent / scene) if is_file and self._file is not None else scene


def trials_of(protocol: Protocol, group: Group | None = None) -> tuple[Trial, ...]:
    """Return every condition-scene pair, or those that a group meets."""
    wanted = group.conditions if group else ()
    return tuple(
        Trial(scene=scene, condition=condition.name)
        for condition in protocol.conditions
        if not wanted or condition.name in wanted
        for scene in protocol.scenes
    )


def part_trials(protocol: Protocol, part: Part, group: Group | None = None) -> tuple[Trial, ...]:
    """Return the condition-scene pairs, or a group's, of a part with orders made by a rule."""
    return tuple(
        trial
        for trial in trials_of(protocol, group)
        if (not part.conditions or trial.condition in part.conditions)
        and (not part.scenes or trial.scene in part.scenes)
    )


def factor_names(protocol: Protocol) -> list[str]:
    """Return the names of the crossed factors."""
    return [factor.name for factor in protocol.factors]


def level_of(protocol: Protocol, trial: Trial, factor: str) -> str:
    """Return the level that a trial has of `condition`, `scene`, `trial` or a crossed factor."""
    if factor == "scene":
        return trial.scene
    if factor == "condition":
        return trial.condition
    if factor == "trial":
        return f"{trial.condition} in {trial.scene}"
    return protocol.condition(trial.condition).levels[factor]


def trial_counts(protocol: Protocol) -> tuple[int, int]:
    """Return how many sessions there are, and how many trials the longest of them has."""
    order = protocol.order
    if order.rule == "explicit":
        sessions = [each.sessions for each in order.sequences]
        lengths = [len(session) for each in sessions for session in each]
        return max(map(len, sessions), default=0), max(lengths, default=0)
    if order.rule == "parts":
        each_group = [_by_session(protocol, group) for group in protocol.groups or (None,)]
        longest = max(max(counts.values(), default=0) for counts in each_group)
        return max(map(len, each_group)), longest
    most = max(len(trials_of(protocol, group)) for group in protocol.groups or (None,))
    return order.sessions, most * order.blocks // order.sessions


def _by_session(protocol: Protocol, group: Group | None) -> Counter[int]:
    """Return how many trials of its parts a group meets in each session."""
    counts = Counter[int]()
    for part in protocol.parts:
        written = orders_of(part, group.name if group else "")
        made = written[0].trials if written else part_trials(protocol, part, group)
        counts[part.session] += len(made) * part.repeats
    return counts
