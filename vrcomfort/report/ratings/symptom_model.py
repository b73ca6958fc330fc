"""The fast–slow model of symptoms, fitted to each person and compared between conditions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.analyses.contract import MethodsParagraph
from vrcomfort.report.rows import INLINE, Cells, as_json
from vrcomfort.stats.rating_courses import Constants, Parameter, SymptomFit, fit_symptoms
from vrcomfort.stats.t_tests import paired_t

if TYPE_CHECKING:
    from vrcomfort.report.rated_exposures import RatedExposure
    from vrcomfort.report.ratings.settings import RatingAnalysis


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter of one person's model; no interval where it is at a limit."""

    estimate: float
    low: float | None
    high: float | None

    @classmethod
    def of(cls, parameter: Parameter) -> ParameterEstimate:
        """Return the row of a fitted parameter."""
        return cls(*parameter)


@dataclass(frozen=True)
class PersonFit:
    """The model of one person."""

    participant: str
    n: int
    levels: dict[str, ParameterEstimate]
    """By condition; conditions without symptoms are not in it."""
    without_symptoms: list[str]
    sensitisation: ParameterEstimate
    residual_sd: float
    r_squared: float
    autocorrelation: float

    @classmethod
    def of(cls, participant: str, fit: SymptomFit) -> PersonFit:
        """Return the row of a fit."""
        return cls(
            participant=participant,
            n=fit.n,
            levels={name: ParameterEstimate.of(level) for name, level in fit.levels.items()},
            without_symptoms=list(fit.without_symptoms),
            sensitisation=ParameterEstimate.of(fit.sensitisation),
            residual_sd=fit.residual_sd,
            r_squared=fit.r_squared,
            autocorrelation=fit.autocorrelation,
        )


@dataclass(frozen=True)
class UnfittedPerson:
    """A person without a model, and the reason."""

    participant: str
    reason: str


@dataclass(frozen=True)
class Quartiles:
    """The median and the quartiles of values of people."""

    median: float
    q1: float
    q3: float


@dataclass(frozen=True)
class Spread:
    """Quartiles over people; an empty object in results.json without values."""

    quartiles: Quartiles | None = field(metadata=INLINE)


@dataclass(frozen=True)
class ConditionLevel:
    """The levels of a condition over people, and the number of people without symptoms."""

    condition: str
    people: int
    well: int
    quartiles: Quartiles = field(metadata=INLINE)


@dataclass(frozen=True)
class LevelRatio:
    """The geometric mean of a's level over b's, with its interval over people."""

    a: str
    b: str
    n: int
    ratio: float
    low: float
    high: float
    t: float | None
    df: float
    p: float | None


@dataclass(frozen=True)
class SymptomModelAnalysis:
    """The models of all people, and the comparison of conditions."""

    constants: Constants
    people: list[PersonFit]
    unfitted: list[UnfittedPerson]
    levels: list[ConditionLevel]
    sensitisation: Spread
    without_sensitisation: int
    residual_sd: Spread
    r_squared: Spread
    ratios: list[LevelRatio]


def symptom_model(
    exposures: list[RatedExposure],
    conditions: list[str],
    asked: RatingAnalysis,
    confidence: float,
) -> SymptomModelAnalysis:
    """Fit each person, and compare the levels of conditions within people.

    Levels are compared as ratios: ln a differs between two conditions by what the ratings do as a
    ratio, whatever the scale.
    """
    constants = Constants(asked.fast_s, asked.slow_s, asked.exponent)
    fits: dict[str, SymptomFit] = {}
    unfitted = []
    for who in dict.fromkeys(e.participant for e in exposures):
        mine = [(e.condition, e.course) for e in exposures if e.participant == who]
        try:
            fits[who] = fit_symptoms(mine, constants, confidence)
        except InputError as error:
            unfitted.append(UnfittedPerson(who, error.message))
    pairs = [(a, b) for a in conditions for b in conditions[: conditions.index(a)]]
    ratios = [_ratio(a, b, fits, confidence) for a, b in pairs]
    levels = [_level(condition, fits) for condition in conditions]
    return SymptomModelAnalysis(
        constants=constants,
        people=[PersonFit.of(who, fit) for who, fit in fits.items()],
        unfitted=unfitted,
        levels=[row for row in levels if row is not None],
        sensitisation=Spread(_quartiles([f.sensitisation.estimate for f in fits.values()])),
        without_sensitisation=sum(f.sensitisation.low is None for f in fits.values()),
        residual_sd=Spread(_quartiles([fit.residual_sd for fit in fits.values()])),
        r_squared=Spread(_quartiles([fit.r_squared for fit in fits.values()])),
        ratios=[row for row in ratios if row is not None],
    )


def _level(condition: str, fits: dict[str, SymptomFit]) -> ConditionLevel | None:
    known = [f.levels[condition].estimate for f in fits.values() if condition in f.levels]
    well = sum(condition in f.without_symptoms for f in fits.values())
    quartiles = _quartiles(known)
    return None if quartiles is None else ConditionLevel(condition, len(known), well, quartiles)


def _quartiles(values: list[float]) -> Quartiles | None:
    finite = [v for v in values if np.isfinite(v)]
    if not finite:
        return None
    low, median, high = (float(q) for q in np.quantile(finite, (0.25, 0.5, 0.75)))
    return Quartiles(median, low, high)


def _ratio(a: str, b: str, fits: dict[str, SymptomFit], confidence: float) -> LevelRatio | None:
    both = [f.levels for f in fits.values() if a in f.levels and b in f.levels]
    logs = [float(np.log(x[a].estimate / x[b].estimate)) for x in both]
    found = paired_t(logs, confidence=confidence)
    if found is None or found.low is None or found.high is None:
        return None
    return LevelRatio(
        a=a,
        b=b,
        n=found.n,
        ratio=float(np.exp(found.mean)),
        low=float(np.exp(found.low)),
        high=float(np.exp(found.high)),
        t=found.t,
        df=found.df,
        p=found.p,
    )


def symptom_model_tables(found: SymptomModelAnalysis) -> dict[str, list[Cells]]:
    """Return name → lines of the CSV tables: a line for each person and condition, and ratios."""
    return {
        "symptom_model": [
            *(line for person in found.people for line in _person_lines(person)),
            *as_json(found.unfitted),
        ],
        "symptom_model_ratios": as_json(found.ratios),
    }


def _person_lines(person: PersonFit) -> list[Cells]:
    names = [(name, _columns("level", level)) for name, level in person.levels.items()]
    # A fit without ratings above 0 has a level of 0, and no interval.
    names += [(name, {"level": 0.0}) for name in person.without_symptoms]
    fitted = {
        **_columns("sensitisation", person.sensitisation),
        "n": person.n,
        "residual_sd": person.residual_sd,
        "r_squared": person.r_squared,
        "autocorrelation": person.autocorrelation,
    }
    return [
        {
            "participant": person.participant,
            "condition": name,
            **level,
            **(fitted if name in person.levels else {}),
        }
        for name, level in names
    ]


def _columns(name: str, found: ParameterEstimate) -> dict[str, float | None]:
    return {name: found.estimate, f"{name}_low": found.low, f"{name}_high": found.high}


def symptom_model_paragraph(constants: Constants) -> MethodsParagraph:
    """Return the paragraph on the model."""
    text = (
        f"Oman’s (1990) model has a fast ({constants.fast_s:g} s) and a slow "
        f"({constants.slow_s:g} s) path of second order, the slow one making the fast one more "
        f"sensitive, and a power law of exponent {constants.exponent:g} (Irmak et al., 2022). "
        "It was fitted to each person by least squares, with a level for each condition and one "
        "sensitisation; its errors allow for residuals that correlate in time. Each exposure is "
        "taken to begin without symptoms and to be as strong from its start to its end."
    )
    return MethodsParagraph("Model of symptoms", text, ("oman_1990", "irmak_2022"))
