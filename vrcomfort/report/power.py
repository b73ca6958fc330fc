"""Power of a plan's primary test, by number of participants: simulated as the report tests."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report import palette
from vrcomfort.report.build import choose_plan
from vrcomfort.report.canvas import Drawing, canvas
from vrcomfort.report.contrasts import conditions_of, contrasts_of
from vrcomfort.report.derived_plan import with_outcomes
from vrcomfort.report.exclusions import apply_rules
from vrcomfort.report.exposures import score_exposures
from vrcomfort.report.pairs import pair_up
from vrcomfort.report.plan_files import find_plan, load_plan
from vrcomfort.report.rows import Cells
from vrcomfort.report.study_data import read_study
from vrcomfort.stats.power import (
    Generator,
    NormalDifferences,
    PairedTest,
    Power,
    ResampledDifferences,
    p_values,
    power_of,
    t_test_power,
)
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan

    Work = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]

STUDIES_AT_ONCE = 500
"""In a piece of work; the seed of a piece is of its place, so that results hang on no process."""
MOST_PARTICIPANTS = 500
TITLES = {"signed_rank": "signed-rank test", "paired_t": "paired t test"}


class Effect(NamedTuple):
    """A mean difference: in standard deviations of the differences, or in points of the score."""

    size: float
    standardised: bool

    @classmethod
    def of_text(cls, text: str) -> Effect:
        """Read ``0.5sd``, or ``10`` points.

        Raises
        ------
        InputError
            If it is neither.
        """
        number = text.strip().lower().removesuffix("sd")
        try:
            size = float(number)
        except ValueError:
            size = math.nan
        if not math.isfinite(size) or abs(size) > 1e6:
            message = "is no effect; write 0.5sd (standard deviations of the differences) or 10"
            raise InputError(f"--effect {text!r} {message} (points of the score)")
        return cls(size, text.strip().lower().endswith("sd"))


class Pilot(NamedTuple):
    """Differences of a pilot study's primary contrast, in whole steps of `unit` points."""

    differences: tuple[int, ...]
    unit: float

    @property
    def sd_points(self) -> float:
        """Return their standard deviation."""
        return float(np.std(self.differences, ddof=1)) * self.unit


@dataclass(frozen=True)
class Question:
    """Settings of a simulation.

    Parameters
    ----------
    outcome, contrast
        Names of the primary ones.
    holm_tests
        Tests in the family of the primary outcome; 1: it is not adjusted.
    """

    outcome: str
    contrast: str
    test: PairedTest
    holm_tests: int
    generator: Generator
    generator_in_words: str
    effect_sd: float | None
    """None where the differences are a pilot's, without another effect."""


class PowerRow(NamedTuple):
    """The power of a study of n people."""

    n: int
    power: Power
    adjusted: Power | None
    """Where every other test of the family finds nothing: at the first step of Holm. None: not
    adjusted."""
    t_test: Power
    t_test_formula: float | None
    """None where differences are not normal."""


def parse_participants(text: str) -> tuple[int, ...]:
    """Read ``8:60``, ``8:60:4`` or ``20``: numbers of participants, the last included.

    Raises
    ------
    InputError
        If it is none of them, or too many.
    """
    parts = text.split(":")
    if not (1 <= len(parts) <= 3 and all(part.strip().isdecimal() for part in parts)):
        raise InputError(f"--participants {text!r} is not a range; write 8:60, 8:60:4 or 20")
    first, last = int(parts[0]), int(parts[1] if len(parts) > 1 else parts[0])
    step = int(parts[2]) if len(parts) > 2 else max(1, (last - first) // 13)
    if not (2 <= first <= last <= MOST_PARTICIPANTS and step):
        message = f"needs 2 to {MOST_PARTICIPANTS} people, the smaller number first"
        raise InputError(f"--participants {text!r} {message}")
    return tuple(sorted({*range(first, last + 1, step), last}))


def read_pilot(study: Path, plan_name: str) -> tuple[Plan, Pilot]:
    """Return the plan, and the differences of its primary contrast in a pilot study.

    Raises
    ------
    InputError
        If fewer than four people have a pair, or none of them differs from another.
    """
    data = read_study(study)
    plan = with_outcomes(choose_plan(data, plan_name), data)
    scored, _ = apply_rules(score_exposures(data, plan), data, plan)
    conditions = conditions_of(scored, data.labels)
    contrasts = contrasts_of(plan, conditions, list(dict.fromkeys([*conditions, *data.labels])))
    if not contrasts or not scored.outcomes:
        raise InputError("this pilot has no two conditions to compare", file=study)
    first = contrasts[0]
    pairs = pair_up(scored, scored.outcomes[0].name, first.a, first.b, complete=True)
    differences = tuple(pairs.differences.tolist())
    if len(differences) < 4 or len(set(differences)) == 1:
        message = f"{len(differences)} people have a pair of {first.a.name} and {first.b.name}"
        message += "; a pilot needs at least four, with differences that vary"
        raise InputError(message, file=study)
    return plan, Pilot(differences, pairs.unit)


def question_of(
    plan_name: str, effect: Effect | None, *, sd: float | None = None, pilot: Path | None = None
) -> Question:
    """Return the settings of a simulation of a plan's primary test.

    Parameters
    ----------
    effect
        None: that of the pilot.
    sd
        Standard deviation of the differences, in points, for an effect in points without a pilot.

    Raises
    ------
    InputError
        If the plan cannot be read, or the effect cannot be told in its standard deviations.
    """
    found = None
    if pilot is not None:
        plan, found = read_pilot(pilot, plan_name)
    else:
        plan = load_plan(find_plan(plan_name))
    first = plan.contrasts[0] if plan.contrasts else None
    alternative = (first.alternative if first else None) or plan.alternative
    test = PairedTest(
        _test_of(plan), alternative, level_of(plan.confidence), plan.zeros, plan.p_value
    )
    generator, words, effect_sd = _generator(effect, sd, found)
    return Question(
        outcome=plan.outcomes[0] if plan.outcomes else "the primary score",
        contrast=f"{first.a or first.a_timepoint} − {first.b or first.b_timepoint}" if first
        else "two conditions",
        test=test,
        holm_tests=_holm_tests(plan),
        generator=generator,
        generator_in_words=words,
        effect_sd=effect_sd,
    )  # fmt: skip


def _test_of(plan: Plan) -> Literal["signed_rank", "paired_t"]:
    """Return the test of the first contrast.

    Raises
    ------
    InputError
        If it is one that is not simulated.
    """
    first = plan.contrasts[0] if plan.contrasts else None
    test = (first.test if first else None) or "signed_rank"
    if first is not None and first.between:
        message = "compares groups, and power is simulated for pairs alone"
        raise plan.fault(f"the first contrast {message}; put one of pairs first", "contrasts", 0)
    if test not in {"signed_rank", "paired_t"}:
        message = f"the power of `{test}` is not simulated; that of signed_rank and paired_t is"
        raise plan.fault(message, "contrasts", 0, "test")
    return "paired_t" if test == "paired_t" else "signed_rank"


def _generator(
    effect: Effect | None, sd: float | None, pilot: Pilot | None
) -> tuple[Generator, str, float | None]:
    if pilot is not None:
        people = f"resampled from {len(pilot.differences)} people of the pilot"
        if effect is None:
            return ResampledDifferences(pilot.differences), f"{people}, as they are", None
        points = effect.size * (pilot.sd_points if effect.standardised else 1.0)
        generator = ResampledDifferences(pilot.differences, points / pilot.unit)
        return generator, f"{people}, moved to {points:.4g} points", points / pilot.sd_points
    if effect is None:
        raise InputError("give --effect, or --pilot to use the effect of a pilot study")
    if effect.standardised:
        return NormalDifferences(effect.size), "normal", effect.size
    if sd is None or not sd > 0:
        message = "an effect in points needs the standard deviation of the differences"
        raise InputError(f"{message}: give --sd, or --pilot, or the effect as 0.5sd")
    words = f"normal, of mean {effect.size:.4g} and standard deviation {sd:.4g} points"
    return NormalDifferences(effect.size / sd), words, effect.size / sd


def _holm_tests(plan: Plan) -> int:
    if not plan.outcomes:
        return 1
    for family in plan.families:
        if plan.outcomes[0] in family.outcomes and family.method == "holm":
            return max(1, len(plan.contrasts)) * len(family.outcomes)
    return 1


class _Piece(NamedTuple):
    question: Question
    n: int
    seed: list[int]
    studies: int


def simulate_power(
    question: Question,
    participants: Iterable[int],
    *,
    studies: int,
    seed: int,
    work: Work = map,
    advance: Callable[[int], None] = lambda _: None,
) -> list[PowerRow]:
    """Simulate a number of studies of each size.

    Parameters
    ----------
    work
        Calls a function for every piece of work: `map`, or that of `vrcomfort.workers`.
    advance
        Called with the number of studies that were simulated since.
    """
    sizes = list(participants)
    pieces = [
        _Piece(question, n, [seed, n, start], min(STUDIES_AT_ONCE, studies - start))
        for n in sizes
        for start in range(0, studies, STUDIES_AT_ONCE)
    ]
    found: dict[int, list[np.ndarray[Any, Any]]] = {n: [] for n in sizes}
    for n, p in work(_simulated, pieces):
        found[n].append(p)
        advance(len(p))
    return [_row(question, n, np.concatenate(found[n])) for n in sizes]


def _simulated(piece: _Piece) -> tuple[int, np.ndarray[Any, Any]]:
    tests = (piece.question.test, replace(piece.question.test, name="paired_t"))
    return piece.n, p_values(tests, piece.question.generator, piece.n, piece.seed, piece.studies)


def _row(question: Question, n: int, p: np.ndarray[Any, Any]) -> PowerRow:
    alpha, many = question.test.alpha, question.holm_tests
    formula = None
    if isinstance(question.generator, NormalDifferences):
        effect = question.generator.effect_sd
        formula = t_test_power(effect, n, alpha, question.test.alternative)
    return PowerRow(
        n=n,
        power=power_of(p[:, 0], alpha),
        adjusted=power_of(p[:, 0], alpha / many) if many > 1 else None,
        t_test=power_of(p[:, 1], alpha),
        t_test_formula=formula,
    )


def cells(row: PowerRow) -> Cells:
    """Return a row of ``power.csv``."""
    found: dict[str, float] = {"participants": row.n, "studies": row.power.studies}
    for name, power in (("", row.power), ("holm_", row.adjusted), ("t_test_", row.t_test)):
        if power is not None:
            found |= {f"{name}power": power.share, f"{name}power_low": power.low,
                      f"{name}power_high": power.high}  # fmt: skip
    if row.t_test_formula is not None:
        found["t_test_formula"] = row.t_test_formula
    return found


def draw_power(question: Question, rows: list[PowerRow]) -> Drawing:
    """Draw power over the number of participants, with its intervals."""
    with canvas("power", 5.0, 3.4) as (figure, drawing):
        axes = figure.add_subplot()
        sizes = [row.n for row in rows]
        curves = [(TITLES[question.test.name], palette.colour_of(0), [row.power for row in rows])]
        if rows[0].adjusted is not None:
            first = [row.adjusted for row in rows if row.adjusted is not None]
            curves.append((f"at p ≤ α/{question.holm_tests} (Holm)", palette.colour_of(1), first))
        for label, colour, powers in curves:
            low, high = [each.low for each in powers], [each.high for each in powers]
            axes.fill_between(sizes, low, high, color=colour, alpha=0.2, lw=0)
            axes.plot(sizes, [each.share for each in powers], "o-", color=colour, ms=4, label=label)
        if rows[0].t_test_formula is not None:
            formula = [row.t_test_formula or 0.0 for row in rows]
            axes.plot(sizes, formula, "--", color=palette.SOFT.light, label="t test, by formula")
        axes.axhline(0.8, color=palette.GRID.light, lw=1)
        axes.set(xlabel="Participants", ylabel="Power", ylim=(0, 1.02))
        axes.legend(frameon=False, loc="lower right")
    return drawing
