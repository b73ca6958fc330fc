"""Against JASP, on its example data, which the project may not ship: they have no licence.

So these tests run only where a copy of the data is (`make test-local`), and CI leaves them out.
Against R and NIST, on data that are shipped, see stats/test_oracles.py.
"""

import os
from pathlib import Path

import pandas as pd
import pytest

from vrcomfort.stats.anova import anova

pytestmark = [
    pytest.mark.needs_reference_data,
    pytest.mark.skipif(
        "VRCOMFORT_REFERENCE_DATA" not in os.environ,
        reason="data without a licence: set VRCOMFORT_REFERENCE_DATA to a folder that has them",
    ),
]


def published(name: str) -> pd.DataFrame:
    return pd.read_csv(Path(os.environ["VRCOMFORT_REFERENCE_DATA"]) / "reference" / name)


def test_two_within_factors_are_those_of_jasp():
    wide = published("ref_jasp_AnovaRepeatedMeasures.csv")
    long = wide.rename(columns={"waterneu": "waterneut"}).melt("participant")
    drink = long["variable"].str.extract("(beer|wine|water)(.*)")
    long = long.assign(drink=drink[0], imagery=drink[1])
    effects = anova(
        long, value="value", participant="participant", within=["drink", "imagery"]
    ).effects
    found = {
        e.effect: (e.f, e.sphericity.greenhouse_geisser, e.sphericity.huynh_feldt) for e in effects
    }
    assert found["drink"] == pytest.approx((5.10598, 0.57711, 0.59074), rel=1e-5)
    assert found["imagery"] == pytest.approx((122.5648, 0.74744, 0.79684), rel=1e-5)
    assert found["drink × imagery"] == pytest.approx((17.1549, 0.79840, 0.97859), rel=1e-5)


def test_one_within_factor_is_that_of_jasp():
    wide = published("ref_jasp_AnovaRepeatedMeasuresOneWay.csv")
    long = wide.melt("Celebrity", var_name="food")
    effect = anova(long, value="value", participant="Celebrity", within=["food"]).effects[0]
    assert (effect.f, effect.generalised_eta_squared) == pytest.approx((3.79381, 0.32742), abs=5e-6)
