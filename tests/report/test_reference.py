"""A report of published answers, which the project may not ship: they have no licence.

So this test runs only where a copy of the data is (`make test-local`), and CI leaves it out.
The numbers are those of R (coin, effectsize, lmerTest).
"""

import csv
import json
import os
from pathlib import Path

import pytest

from tests.support.report import build_report
from vrcomfort.questionnaire import shipped_instruments

SSQ = shipped_instruments()["ssq"]

pytestmark = [
    pytest.mark.needs_reference_data,
    pytest.mark.skipif(
        "VRCOMFORT_REFERENCE_DATA" not in os.environ,
        reason="data without a licence: set VRCOMFORT_REFERENCE_DATA to a folder that has them",
    ),
]


def long_form(path: Path) -> Path:
    """Write the crossover as a long table: round 1 of group A and 2 of B are control."""
    data = Path(os.environ["VRCOMFORT_REFERENCE_DATA"])
    with (data / "ssq/jgxuann_SSQ_items.csv").open(encoding="utf-8-sig") as stream:
        wide = list(csv.DictReader(stream))
    lines = ["participant,period,sequence,condition,timepoint,instrument,item,response"]
    for row in wide:
        control = (row["Group"] == "A") == (row["Round"] == "1")
        who = f"{row['No.']},{row['Round']},{row['Group']}"
        which = "control" if control else "treatment"
        lines += [
            f"{who},{which},post,ssq,{SSQ.item(heading).name},{answer}"
            for heading, answer in row.items()
            if SSQ.item(heading)
        ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_report_gives_the_tie_safe_numbers(tmp_path):
    source = long_form(tmp_path / "questionnaires.csv")
    plan = tmp_path / "plan.toml"
    plan.write_text('name = "r"\ntitle = "R"\nrank_biserial_interval = "effectsize"\n')
    summary = build_report(source, plan=plan, out=tmp_path / "o")
    results = json.loads(summary.results.read_text("utf-8"))
    expected = {
        "T": (3.123865, 0.0006713867, 0.001784926, 1, 0.84, 0.59, 0.94),
        "N": (1.495949, 0.1699219, 0.134667, 7, 0.47, -0.08, 0.80),
        "O": (3.53654, 0.0001068115, 0.0004054047, 1, 0.95, 0.87, 0.98),
        "D": (2.306996, 0.01812744, 0.02105505, 3, 0.65, 0.23, 0.87),
    }
    for test in results["tests"]:
        z, exact, asymptotic, zeros, *effect = expected[test["outcome"]]
        found = (test["z"], test["p_exact"], test["p_asymptotic"])
        assert found == pytest.approx((z, exact, asymptotic), rel=1e-6)
        assert test["zeros"] == zeros
        assert [round(test["effect"][k], 2) for k in ("estimate", "low", "high")] == effect
    total = results["crossover"][0]
    assert total["condition"]["estimate"] == pytest.approx(13.60425)
    assert total["period"]["estimate"] == pytest.approx(-2.85175)
    assert total["sequence"]["p"] == pytest.approx(0.8888333, rel=1e-6)
    assert results["score_basis"] == "raw_post"
