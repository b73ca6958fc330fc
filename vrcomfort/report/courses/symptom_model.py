"""The fast–slow model of symptoms, fitted to each person and compared between conditions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.stats.rating_courses import Constants, SymptomFit, fit_symptoms
from vrcomfort.stats.t_tests import paired_t

if TYPE_CHECKING:
    from vrcomfort.report.courses.exposures import RatedExposure
    from vrcomfort.report.plan.ratings import RatingAnalysis


Row = dict[str, Any]


def symptom_fits(
    exposures: list[RatedExposure],
    conditions: list[str],
    asked: RatingAnalysis,
    confidence: float,
) -> Row:
    """Fit everybody, and compare the levels of conditions within people.

    Levels are compared as ratios: ln a differs between two conditions by what the ratings do as a
    ratio, whatever the scale.
    """
    constants = Constants(asked.fast_s, asked.slow_s, asked.exponent)
    fits: dict[str, SymptomFit] = {}
    unfitted: list[Row] = []
    for who in dict.fromkeys(e.participant for e in exposures):
        mine = [(e.condition, e.course) for e in exposures if e.participant == who]
        try:
            fits[who] = fit_symptoms(mine, constants, confidence)
        except InputError as error:
            unfitted.append({"participant": who, "reason": error.message})
    return {
        "constants": {"fast_s": asked.fast_s, "slow_s": asked.slow_s, "exponent": asked.exponent},
        "people": [_person(who, fit) for who, fit in fits.items()],
        "unfitted": unfitted,
        "levels": [row for c in conditions if (row := _level(c, fits))],
        "sensitisation": _spread([fit.sensitisation.estimate for fit in fits.values()]),
        "without_sensitisation": sum(f.sensitisation.low is None for f in fits.values()),
        "residual_sd": _spread([fit.residual_sd for fit in fits.values()]),
        "r_squared": _spread([fit.r_squared for fit in fits.values()]),
        "ratios": [
            row
            for a in conditions
            for b in conditions[: conditions.index(a)]
            if (row := _ratio(a, b, fits, confidence))
        ],
    }


def _person(who: str, fit: SymptomFit) -> Row:
    return {
        "participant": who,
        "n": fit.n,
        "levels": {name: level._asdict() for name, level in fit.levels.items()},
        "without_symptoms": list(fit.without_symptoms),
        "sensitisation": fit.sensitisation._asdict(),
        "residual_sd": fit.residual_sd,
        "r_squared": fit.r_squared,
        "autocorrelation": fit.autocorrelation,
    }


def person_rows(fits: Row) -> list[Row]:
    """Return a row for each person and condition, for a table."""
    rows = []
    for person in fits["people"]:
        same = {key: person[key] for key in ("n", "residual_sd", "r_squared", "autocorrelation")}
        h = {f"sensitisation{end}": person["sensitisation"][key] for key, end in _ENDS.items()}
        for condition, level in person["levels"].items():
            values = {f"level{end}": level[key] for key, end in _ENDS.items()}
            one = {"participant": person["participant"], "condition": condition}
            rows.append({**one, **values, **h, **same})
        rows += [
            {"participant": person["participant"], "condition": name, "level": 0.0}
            for name in person["without_symptoms"]
        ]
    return rows + [dict(row) for row in fits["unfitted"]]


_ENDS = {"estimate": "", "low": "_low", "high": "_high"}


def _level(condition: str, fits: dict[str, SymptomFit]) -> Row | None:
    known = [f.levels[condition].estimate for f in fits.values() if condition in f.levels]
    well = sum(condition in f.without_symptoms for f in fits.values())
    spread = _spread(known)
    return (
        {"condition": condition, "people": len(known), "well": well, **spread} if spread else None
    )


def _spread(values: list[float]) -> Row:
    """Return the median and the quartiles; nothing of no values."""
    finite = [v for v in values if np.isfinite(v)]
    if not finite:
        return {}
    low, median, high = (float(q) for q in np.quantile(finite, (0.25, 0.5, 0.75)))
    return {"median": median, "q1": low, "q3": high}


def _ratio(a: str, b: str, fits: dict[str, SymptomFit], confidence: float) -> Row | None:
    """Return the geometric mean of a's level over b's, with its interval over people."""
    both = [f.levels for f in fits.values() if a in f.levels and b in f.levels]
    logs = [float(np.log(x[a].estimate / x[b].estimate)) for x in both]
    found = paired_t(logs, confidence=confidence)
    if found is None or found.low is None or found.high is None:
        return None
    return {
        "a": a,
        "b": b,
        "n": found.n,
        "ratio": float(np.exp(found.mean)),
        "low": float(np.exp(found.low)),
        "high": float(np.exp(found.high)),
        "t": found.t,
        "df": found.df,
        "p": found.p,
    }
