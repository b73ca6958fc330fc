"""Against published data that the project may not ship.

Set VRCOMFORT_REFERENCE_DATA to a folder with ``ssq/`` and ``reference/`` to have these tests;
without it there are none.
"""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from vrcomfort.stats.anova import anova
from vrcomfort.stats.crossover import crossover
from vrcomfort.stats.ranks import as_integers
from vrcomfort.stats.signed_rank import signed_rank

if "VRCOMFORT_REFERENCE_DATA" in os.environ:
    DATA = Path(os.environ["VRCOMFORT_REFERENCE_DATA"])

    def crossover_scores() -> pd.DataFrame:
        wide = pd.read_csv(DATA / "ssq/jgxuann_SSQ_scored.csv")
        control = (wide["Group"] == "A") == (wide["Round"] == 1)
        return wide.assign(condition=np.where(control, "control", "treatment"))

    def test_tie_safe_numbers_of_r_coin_and_effectsize():
        expected = {
            "SSQ_Total": (3.74, 3.123865, 0.0006713867, 0.001784926, 1, 0.84, 0.59, 0.94),
            "Nausea": (9.54, 1.495949, 0.1699219, 0.134667, 7, 0.47, -0.08, 0.80),
            "Oculomotor": (7.58, 3.53654, 0.0001068115, 0.0004054047, 1, 0.95, 0.87, 0.98),
            "Disorientation": (13.92, 2.306996, 0.01812744, 0.02105505, 3, 0.65, 0.23, 0.87),
        }
        for column, (unit, z, exact, asymptotic, zeros, *effect) in expected.items():
            paired = crossover_scores().pivot_table(index="ID", columns="condition", values=column)
            a, b = (as_integers(paired[c], unit) for c in ("control", "treatment"))
            test = signed_rank(a - b, unit, interval_n=int(np.count_nonzero(a)))
            assert (test.z, test.p_exact, test.p_asymptotic) == pytest.approx(
                (z, exact, asymptotic), rel=1e-6
            )
            assert test.zeros == zeros
            found = [test.effect.estimate, test.effect.low, test.effect.high]
            assert [round(x, 2) for x in found] == effect

    def test_crossover_model_of_lmer():
        periods = crossover_scores().pivot_table(
            index=["ID", "Group"], columns="Round", values="SSQ_Total"
        ).reset_index()  # fmt: skip
        model = crossover(periods[1], periods[2], periods["Group"] == "A")
        assert model.condition.estimate == pytest.approx(13.60425, abs=5e-6)
        assert model.condition.standard_error == pytest.approx(3.732304, rel=1e-6)
        assert model.condition.p == pytest.approx(2.181635e-3, rel=1e-6)
        assert (model.period.estimate, model.period.p) == pytest.approx(
            (-2.85175, 0.4559451), rel=1e-6
        )
        assert (model.sequence.estimate, model.sequence.p) == pytest.approx(
            (1.54275, 0.8888333), rel=1e-6
        )

    def test_tooth_growth():
        data = pd.read_csv(DATA / "reference/ref_R_ToothGrowth.csv")
        data["cell"] = data["supp"] + data["dose"].astype(str)
        data["id"] = data.index
        one_way = anova(data, value="len", participant="id", between="cell").effects[0]
        assert one_way.error_sum_of_squares == pytest.approx(712.1, abs=0.05)
        assert one_way.sum_of_squares == pytest.approx(205.4 + 2426.4 + 108.3, abs=0.1)

    def test_jasp_two_within_factors():
        wide = pd.read_csv(DATA / "reference/ref_jasp_AnovaRepeatedMeasures.csv")
        long = wide.rename(columns={"waterneu": "waterneut"}).melt("participant")
        drink = long["variable"].str.extract("(beer|wine|water)(.*)")
        long = long.assign(drink=drink[0], imagery=drink[1])
        effects = anova(
            long, value="value", participant="participant", within=["drink", "imagery"]
        ).effects
        found = {
            e.effect: (e.f, e.sphericity.greenhouse_geisser, e.sphericity.huynh_feldt)
            for e in effects
        }
        assert found["drink"] == pytest.approx((5.10598, 0.57711, 0.59074), rel=1e-5)
        assert found["imagery"] == pytest.approx((122.5648, 0.74744, 0.79684), rel=1e-5)
        assert found["drink × imagery"] == pytest.approx((17.1549, 0.79840, 0.97859), rel=1e-5)

    def test_jasp_one_way():
        wide = pd.read_csv(DATA / "reference/ref_jasp_AnovaRepeatedMeasuresOneWay.csv")
        long = wide.melt("Celebrity", var_name="food")
        effect = anova(long, value="value", participant="Celebrity", within=["food"]).effects[0]
        assert (effect.f, effect.generalised_eta_squared) == pytest.approx(
            (3.79381, 0.32742), abs=5e-6
        )
