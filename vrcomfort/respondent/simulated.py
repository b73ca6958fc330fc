"""Simulated participants: a latent sickness that grows with exposure, and ordinal answers to it.

Not a model of anybody in particular. It gives an analysis something with the structure of real
data: people who differ, answers that tie, symptoms that carry over, and withdrawals that depend on
how people feel (so that completers are a biased sample).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from enum import IntEnum, unique
from typing import Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array, Gaze, Pose
from vrcomfort.protocol import Simulation
from vrcomfort.protocol.adjustments import Adjustment
from vrcomfort.questionnaire import Instrument, Item
from vrcomfort.respondent.base import Exposure, Form, Heard, InstructionContent, Withdrew, Written
from vrcomfort.respondent.simulated_eyes import EyePair, Eyes
from vrcomfort.respondent.simulated_hands import (
    SimulatedAdjuster,
    SimulatedHands,
    SimulatedSlider,
    Turn,
)
from vrcomfort.tasks import Demand

LOADINGS: Mapping[str, float] = {
    "general_discomfort": 1.1,
    "fatigue": 0.8,
    "headache": 0.7,
    "eyestrain": 1.3,
    "difficulty_focusing": 1.0,
    "increased_salivation": 0.4,
    "sweating": 0.6,
    "nausea": 1.0,
    "difficulty_concentrating": 0.7,
    "fullness_of_head": 0.8,
    "blurred_vision": 0.8,
    "dizzy_eyes_open": 0.9,
    "dizzy_eyes_closed": 0.8,
    "vertigo": 0.6,
    "stomach_awareness": 0.8,
    "burping": 0.3,
}
"""item → how much of a unit of sickness shows in it. Assumed: vision first, stomach later."""

USUAL_LOADING = 0.8
"""Of any other item."""

THRESHOLDS = (0.8, 1.7, 2.6)
"""Latent levels from which people give the second, third and fourth of four answers."""

_SICKNESS_OF_RANGE = 4.0
"""Sickness at which other scales end: 5 steps of FMS per unit, 2.5 of MISC."""
# Median; their logarithm has a standard deviation of 0.3.
_SECONDS_PER_ANSWER = 3.0
_SHORTEST_S = 1e-6
"""Less is no time: clocks count nanoseconds."""
_SECONDS_PER_WORD, _SECONDS_PER_PICTURE = 0.3, 5.0
"""Of instructions: 200 words a minute."""
# Of an exposure, over which the hazard is summed.
_STEPS = 1000
# No simulated participant gets near it: a kept state that says more is damaged.
_UNHEARD_OF = 1e6


@unique
class _Stream(IntEnum):
    """Last key of each random stream that is not the answers': two never draw the same numbers."""

    HANDS = 4
    EYES = 5
    DIAL = 6
    BREAKS = 7
    SLIDER = 8
    WORDS = 9
    DECISION = 10
    SKILL = 11
    EFFECT = 12


SAID = (
    ("", "Nothing in particular.", "It looked good."),
    ("A bit odd when I turned.", "Things at the side were blurred, weren't they?"),
    ("My eyes are tired.\nThe near things were hard to look at.", "Warm."),
    ('I felt "seasick".', "Too much; I'd have stopped soon."),
)
"""Free texts of simulated participants, by their sickness in whole units."""


class SimulatedRespondent:
    """One simulated participant; the same seed and name give the same person and answers."""

    name = "simulated"

    def __init__(
        self,
        settings: Simulation,
        *,
        participant: str,
        seed: int,
        covariates: Mapping[str, str] | None = None,
    ) -> None:
        self._settings = settings
        self._seed = seed
        self._person = _hash(participant)
        rng = self._stream(0)
        self.susceptibility = math.exp(settings.susceptibility_sigma * rng.standard_normal())
        levels = settings.baseline_sd * rng.standard_normal(len(LOADINGS))
        self._levels: dict[str, float] = dict(zip(LOADINGS, levels.tolist(), strict=True))
        own = settings.task_sigma * self._stream(0, _Stream.SKILL).standard_normal()
        effects = settings.skill_effects
        factors = [effects.get(k, {}).get(v, 1.0) for k, v in (covariates or {}).items()]
        self._skill = math.prod(factors, start=math.exp(own))
        self._start_again(session=1)

    def _stream(self, *key: int) -> np.random.Generator:
        seed = np.random.SeedSequence(self._seed, spawn_key=(self._person, *key))
        return np.random.default_rng(seed)

    def _start_again(self, session: int) -> None:
        self._rng = self._stream(session)
        self._session = session
        self._eyes: Eyes | None = None
        self._break: InstructionContent | None = None
        self._breaks = 0
        self.sickness = 0.0
        self._limit = 0.0
        self._withdraws_at_s = math.inf
        self._answer_at_s = math.inf

    def start_session(self, session: int) -> None:
        """Come back recovered, with the random stream of this session."""
        self._start_again(session)

    def memory(self) -> dict[str, Any]:
        """Return how this person feels between two exposures, and the random stream's place."""
        return {"sickness": self.sickness, "random": self._rng.bit_generator.state}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Be as one was when `memory` was taken, in the session that was started.

        Raises
        ------
        InputError
            If it is no such state.
        """
        try:
            self.sickness = _sickness(memory["sickness"])
            self._rng.bit_generator.state = memory["random"]
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            message = "`memory` is not the state of a simulated participant: this is damaged"
            raise InputError(f"{message}; restore it") from error

    def start_task(self, trial: int, condition: str) -> None:
        """Begin a task, with a random stream of its own: it changes no answer."""
        random = self._stream(self._session, trial, _Stream.HANDS)
        own = self._stream(_hash(condition), _Stream.EFFECT).standard_normal()
        skill = self._skill * math.exp(self._settings.task_effect_sigma * own)
        self._hands = SimulatedHands(self._settings, condition, random, skill)

    def act(self, demand: Demand | None, head: Pose, time_s: float) -> Pose | None:
        """Return world-from-ray of a press in this frame, if there is one."""
        return self._hands.act(demand, head, time_s)

    def next_press_s(self, demand: Demand | None) -> float:
        """Return when they press next; infinite where nothing is to be pressed."""
        return self._hands.next_s(demand)

    def start_adjustment(self, trial: int, adjustment: Adjustment) -> None:
        """Begin to adjust, with random streams of their own: that changes no answer."""
        person = self._stream(_hash(adjustment.name), _Stream.DIAL)
        exposure = self._stream(self._session, trial, _Stream.DIAL)
        self._adjuster = SimulatedAdjuster(self._settings, adjustment, person, exposure)

    def turn(self, place: float, time_s: float) -> Turn:
        """Return the turn of the dial, from its place (0 to 1) in its range."""
        return self._adjuster.turn(place, time_s)

    def start_slider(self, trial: int) -> None:
        """Begin to rate all the time, with a random stream of its own."""
        random = self._stream(self._session, trial, _Stream.SLIDER)
        self._slider = SimulatedSlider(self._settings.noise_sd / _SICKNESS_OF_RANGE, random)

    def slide(self, place: float) -> float:
        """Return where they put a slider, which is at a place (0 to 1) of its range."""
        felt = float(self._after(np.array(self._lived_s))) / _SICKNESS_OF_RANGE
        return self._slider.put(place, felt)

    @property
    def has_eyes(self) -> bool:
        """Return whether an eye tracker would see where they look."""
        return self._settings.eyes is not None

    def look(self, time_s: float, head: Pose, point: Array | None) -> Gaze | None:
        """Return where they look, as an eye tracker says it; None where they have no such eyes."""
        self._eyes = self._eyes or self._opened(0)
        return None if self._eyes is None else self._eyes.look(time_s, head, point)

    def _opened(self, trial: int) -> Eyes | None:
        """Return the eyes of an exposure, with a random stream of their own."""
        settings = self._settings.eyes
        if settings is None:
            return None
        random = self._stream(self._session, trial, _Stream.EYES)
        tracker = self._stream(self._session, _Stream.EYES)
        offset_deg = settings.error_deg * tracker.standard_normal(2)
        own_deg = settings.eye_error_deg * tracker.standard_normal((2, 2))
        noise = self._stream(self._session, trial, _Stream.EYES, 1)
        return Eyes(settings, random, offset_deg, EyePair(settings, noise, offset_deg + own_deg))

    def start_exposure(self, exposure: Exposure) -> None:
        """Decide how fast sickness grows and when it becomes too much."""
        settings = self._settings
        dose = settings.rate_per_min * self.susceptibility
        dose *= settings.habituation ** (self._session - 1)
        dose *= settings.condition_effects.get(exposure.condition, 1.0)
        dose *= settings.scene_effects.get(exposure.scene, 1.0)
        self._limit = dose * settings.recovery_min
        self._eyes = self._opened(exposure.trial)
        self._withdraws_at_s = self._withdrawal(exposure.duration_s)
        self._lived_s = 0.0
        self._answer_at_s = math.inf

    def _withdrawal(self, duration_s: float) -> float:
        """Return when the hazard, summed over time, passes an exponential draw (inf: never)."""
        time_s = np.linspace(0.0, duration_s, _STEPS + 1)[1:]
        excess = np.maximum(self._after(time_s) - self._settings.tolerance, 0.0)
        per_step = self._settings.hazard_per_min * excess * duration_s / 60 / _STEPS
        passed = np.cumsum(per_step) > self._rng.exponential()
        return float(time_s[np.argmax(passed)]) if passed.any() else math.inf

    def _after(self, elapsed_s: np.ndarray) -> np.ndarray:
        """Return sickness after (n,) seconds of s′ = dose − s / recovery, solved exactly."""
        decay = np.exp(-elapsed_s / 60 / self._settings.recovery_min)
        return np.asarray(self._limit + (self.sickness - self._limit) * decay)

    def next_s(self, elapsed_s: float) -> float:
        """Return when they next rate or withdraw, after a time of the exposure."""
        times = (self._withdraws_at_s, self._answer_at_s)
        return min((each for each in times if each > elapsed_s), default=math.inf)

    def update(self, elapsed_s: float) -> None:
        """Withdraw when it has become too much."""
        self._lived_s = elapsed_s
        if elapsed_s >= self._withdraws_at_s:
            raise Withdrew("felt too sick to go on")

    def end_exposure(self, elapsed_s: float) -> None:
        """Keep the sickness reached."""
        self.sickness = float(self._after(np.array(elapsed_s)))
        self._withdraws_at_s = self._answer_at_s = math.inf

    def prompt(self, instrument: Instrument, elapsed_s: float, timeout_s: float) -> None:
        """Think about the rating for a part of the time there is, or miss it."""
        missed = self._rng.random() < self._settings.missed_rating
        thinking = timeout_s * self._rng.uniform(0.1, 0.6)
        self._answer_at_s = math.inf if missed else elapsed_s + thinking
        felt = float(self._after(np.array(elapsed_s))) + self._noise()
        self._answer = _on_the_range(instrument.items[0], felt)

    def rating(self, elapsed_s: float) -> int | None:
        """Return the rating once it has been thought of."""
        return self._answer if elapsed_s >= self._answer_at_s else None

    def resting(self, left_s: float) -> bool:  # noqa: ARG002 - see `rest`
        """Wait."""
        return False

    def rest(self, duration_s: float) -> None:
        """Recover."""
        self._limit = 0.0
        self.sickness = float(self._after(np.array(duration_s)))

    def read(
        self, content: InstructionContent, elapsed_s: float, *, may_go_on: bool
    ) -> float | None:
        """Read all words, look at a picture, hear a sound to its end; draws nothing at random."""
        takes_s = _SECONDS_PER_WORD * len(content.text.split())
        takes_s += _SECONDS_PER_PICTURE if content.picture is not None else 0.0
        takes_s += self._lingers_s(content) if content.away else 0.0
        left_s = max(takes_s, content.sound_s or 0.0) - elapsed_s
        if left_s > _SHORTEST_S:
            return left_s
        return None if may_go_on else math.inf

    def _lingers_s(self, content: InstructionContent) -> float:
        """Return for how long they stay in a break that they may end."""
        if self._break is not content:
            self._break, self._breaks = content, self._breaks + 1
        random = self._stream(self._session, self._breaks, _Stream.BREAKS)
        return self._settings.break_extra_s * float(random.standard_exponential())

    def leave(self) -> None:
        """Do nothing."""

    def ask(self, form: Form, heard: Heard) -> None:
        """Answer, refuse after a withdrawal, or (rarely) withdraw at a question."""
        if form.after_withdrawal and self._rng.random() < self._settings.refusal:
            raise Withdrew("refused the questionnaire")
        for item in form.instrument.items:
            if self._rng.random() < self._settings.question_hazard * self.sickness:
                raise Withdrew(f"stopped at the question {item.name}")
            took_s = _SECONDS_PER_ANSWER * math.exp(0.3 * self._rng.standard_normal())
            response = (
                self._choice(item, form.compared)
                if form.compared
                else self._response(form.instrument, item)
            )
            heard(item.name, response, round(took_s, 2))

    def write(self, question: str) -> Written:
        """Say something that goes with how they feel; it changes no other answer."""
        random = self._stream(self._session, _hash(question), _Stream.WORDS)
        mood = SAID[min(int(self.sickness), len(SAID) - 1)]
        text = mood[int(random.integers(len(mood)))]
        return Written(text, round(2.0 + 0.2 * len(text), 2))

    def decide(self, question: str) -> bool:
        """Decide for the experimenter, by the seed; it changes no answer."""
        random = self._stream(self._session, _hash(question), _Stream.DECISION)
        return bool(random.random() >= self._settings.screened_out)

    def _choice(self, item: Item, compared: Sequence[str]) -> int:
        """Choose the best condition now (Thurstone 1927), or none where two seem alike."""
        liking = self._settings.liking
        seems = [liking.get(each, 0.0) + self._rng.standard_normal() for each in compared]
        best, next_best = sorted(seems, reverse=True)[:2]
        if item.answers.low == 0 and best - next_best < self._settings.indifference:
            return 0
        return seems.index(best) + 1

    def _response(self, instrument: Instrument, item: Item) -> int:
        mean = self._settings.answers.get(item.name)
        if mean is not None:
            asked = item.answers.asked
            return int(asked[self._rng.binomial(len(asked) - 1, mean)])
        if len(instrument.items) == 1:
            return _on_the_range(item, self.sickness + self._noise())
        loading = LOADINGS.get(item.name, USUAL_LOADING)
        latent = self._level(item.name) + loading * self.sickness + self._noise()
        asked = item.answers.asked
        if len(asked) == len(THRESHOLDS) + 1:
            return int(asked[sum(latent > threshold for threshold in THRESHOLDS)])
        return _on_the_range(item, latent)

    def _level(self, item: str) -> float:
        """Return the stable level of an item; of one that is no symptom above, drawn by name."""
        if item not in self._levels:
            rng = self._stream(_hash(item), 0)
            self._levels[item] = self._settings.baseline_sd * float(rng.standard_normal())
        return self._levels[item]

    def _noise(self) -> float:
        return self._settings.noise_sd * float(self._rng.standard_normal())


def _hash(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4])


def _sickness(value: object) -> float:
    if not isinstance(value, int | float) or not 0 <= value < _UNHEARD_OF:
        raise ValueError(value)
    return float(value)


def _on_the_range(item: Item, latent: float) -> int:
    """Return the answer of a scale that begins at no sickness; at its end where it is reversed."""
    asked = item.answers.asked
    steps = len(asked) - 1
    place = min(max(round(latent / _SICKNESS_OF_RANGE * steps), 0), steps)
    return int(asked[steps - place if item.reversed else place])
