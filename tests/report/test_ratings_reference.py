"""Real ratings during exposure, imported, planned and reported: every number that R prints of them.

The numbers are read from R's own output (tests/data/fms/reference_output.txt), and ours have to be
what R printed, to the last digit that it printed.
"""

import re

import pandas as pd
import pytest

from tests.support.places import ROOT
from vrcomfort.importing.convert import import_files
from vrcomfort.importing.mapping import load_mapping
from vrcomfort.importing.study import write_study
from vrcomfort.report.build import build_report, choose_plan
from vrcomfort.report.results import analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.sections import run_sections
from vrcomfort.report.study_data import read_study

FMS = ROOT / "tests" / "data" / "fms"
R = (FMS / "reference_output.txt").read_text("utf-8")
pytestmark = pytest.mark.slow  # what all share takes two seconds
NUMBER = r"-?\d*\.?\d+(?:e[-+]\d+)?"


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Return the folder of the study that the mapping makes of the ratings."""
    folder = tmp_path_factory.mktemp("fms") / "study"
    mapping = load_mapping(FMS / "mapping.toml")
    files = [FMS / "ratings.csv"]
    write_study(folder, import_files(files, mapping.mapping), mapping, files)
    return folder


@pytest.fixture(scope="module")
def results(study):
    """Return what is analysed, without figures and page."""
    data = read_study(study)
    plan = choose_plan(data, FMS / "plan.toml")
    found, _ = analyse(data, plan)
    sections = run_sections(found.for_sections(data))
    return as_json(found.with_sections(sections))


LOG_LOG = """\
  60        0.764        0.867
 120        0.524        0.656
 180        0.354        0.486
 209        0.287        0.414
"""
"""Time, lower and upper: of the same curve, ``print(summary(survfit(Surv(time_s, event) ~ 1, first,
conf.type = "log-log"), times = c(60, 120, 180, 209)))`` of R 4.2.2, where the file has the default
``"log"``; `first` as in tests/data/survival/reference.R."""
SEARCH = 1e-8
"""At which relative precision lme4's search for the variances ends."""


def is_printed(value, text, *, relative=0.0):
    """Return whether R would print a value so: it is within half of the last printed digit.

    `relative` is what R's own number may be wrong by.
    """
    digits, _, power = text.lower().partition("e")
    decimals = len(digits.partition(".")[2])
    unit = 10.0 ** (int(power or 0) - decimals)
    return abs(value - float(text)) <= 0.5000001 * unit + relative * abs(value)


def numbers_after(label):
    """Return the numbers that follow a label at the start of a line, as texts."""
    found = re.search(rf"^ *{re.escape(label)}((?: +[<]?{NUMBER})+)", R, re.MULTILINE)
    return re.findall(NUMBER, found[1])


def after(words):
    return re.search(rf"{words} *({NUMBER})", R)[1]


def summaries(results, name):
    return {d["condition"]: d for d in results["ratings"]["summaries"] if d["summary"] == name}


def model(results, name):
    return next(m for m in results["ratings"]["models"] if m["summary"] == name)


def test_peaks_of_each_condition(results):
    found = summaries(results, "peak")
    assert is_printed(results["ratings"]["exposures"], after("runs"))
    assert is_printed(results["ratings"]["people"], after("people"))
    assert is_printed(found[None]["mean"], after("all runs mean peak"))
    assert is_printed(found[None]["sd"], re.search(rf"sd ({NUMBER})", R)[1])
    rows = re.findall(rf"^\d +(\w+)((?: +{NUMBER}){{4}})$", R, re.MULTILINE)
    assert len(rows) == 9
    for condition, texts in rows:
        mine = found[condition]
        for key, text in zip(("n", "mean", "sd", "median"), texts.split(), strict=True):
            assert is_printed(mine[key], text), (condition, key)


def test_the_mixed_model_of_peaks(results):
    found = model(results, "peak")
    names = ["(Intercept)", *re.findall(r"^condition(\w+) +-?\d", R, re.MULTILINE)]
    names = list(dict.fromkeys(names))
    assert len(names) == 9
    for name in names:
        label = name if name == "(Intercept)" else f"condition{name}"
        term = found["intercept"] if name == "(Intercept)" else found["terms"][
            f"condition: {name} − base"
        ]  # fmt: skip
        keys = ("estimate", "standard_error", "df", "t")
        for key, text in zip(keys, numbers_after(label), strict=True):
            assert is_printed(term[key], text, relative=SEARCH), (name, key)
        p = re.findall(rf"^{re.escape(label)} +({NUMBER})$", R, re.MULTILINE)
        assert is_printed(term["p"], p[0], relative=60 * SEARCH), name  # d ln p is 60 d ln t
    assert is_printed(found["participant_sd"], numbers_after("participant (Intercept)")[0])
    assert is_printed(found["residual_sd"], numbers_after("Residual")[0])
    whole = found["omnibus"]["condition"]
    keys = ("sum_of_squares", "mean_square", "df_effect", "df_error", "f", "p")
    row = re.search(rf"^condition((?: +{NUMBER}){{6}}) +\*", R, re.MULTILINE)[1].split()
    for key, text in zip(keys, row, strict=True):
        assert is_printed(whole[key], text), key


def test_the_time_to_a_rating_of_ten(results):
    (found,) = results["ratings"]["reached"]
    reached, exposures = re.search(r"reached FMS 10: (\d+) of (\d+)", R).groups()
    assert (found["came"], found["n"]) == (int(reached), int(exposures))
    keys = ("time_s", "at_risk", "events", "survival", "standard_error")
    curve = next(c for c in found["curves"] if c["condition"] is None and not c["robust"])
    table = re.search(r"lower 95% CI upper 95% CI\n(.*?)\nCall", R, re.DOTALL)[1].splitlines()
    assert len(table) == 4
    for row, line in zip(curve["at"], table, strict=True):
        for key, text in zip(keys, line.split()[:5], strict=True):
            assert is_printed(row[key], text), (line, key)
    for row, line in zip(curve["at"], LOG_LOG.splitlines(), strict=True):
        for key, text in zip(("time_s", "low", "high"), line.split(), strict=True):
            assert is_printed(row[key], text), (line, key)


def test_the_log_rank_test_of_two_conditions(results):
    (found,) = results["ratings"]["reached"]
    test = next(t for t in found["log_rank"] if len(t["groups"]) == 2 and not t["within_people"])
    for place, group in enumerate(test["groups"]):
        n, observed, expected, share, of_variance = numbers_after(f"condition={group}")
        assert (test["n"][place], test["observed"][place]) == (int(n), int(observed))
        mine = test["expected"][place]
        assert is_printed(mine, expected)
        assert is_printed((test["observed"][place] - mine) ** 2 / mine, share)
        assert is_printed(test["chi_square"], of_variance)
    assert is_printed(test["chi_square"], after("Chisq="))
    assert is_printed(test["p"], re.search(rf"freedom, p= ({NUMBER})", R)[1])
    assert test["df"] == 1


def test_the_paired_tests_of_mean_ratings(results):
    (test,) = results["tests"]
    found = test["t_test"]
    assert is_printed(found["n"], after("paired people"))
    assert is_printed(found["mean"], after("mean diff"))
    assert is_printed(found["t"], after("t ="))
    assert is_printed(found["df"], after("df ="))
    low, high = re.search(rf"interval:\n +({NUMBER}) ({NUMBER})", R).groups()
    assert is_printed(found["low"], low)
    assert is_printed(found["high"], high)
    of_t, of_wilcoxon = re.findall(rf"p-value = ({NUMBER})", R)
    assert is_printed(found["p"], of_t)
    assert is_printed(test["w_plus"], after("V ="))
    assert is_printed(test["p_asymptotic"], of_wilcoxon)


def test_the_page_has_them(study, tmp_path):
    made = build_report(study, plan=FMS / "plan.toml", out=tmp_path, forms=("svg",))
    page = made.index.read_text("utf-8")
    words = " ".join(re.sub(r"<[^>]+>", " ", page).split())
    for text in (
        "141 of 214 exposures reached it",
        "60 176 38 .822 .026 [.764, .867]",
        "209 75 15 .350 .033 [.287, .414]",
        "12.49 0.76 50.29 16.34",
        "8, 138.49 2.25 .027",
        "39 (36.6)",
        "214 43 11.99 4.92",
    ):
        assert text in words, text
    assert 'id="ratings"' in page
    assert {"ratings.svg", "survival_rating.svg"} <= {figure.name for figure in made.figures}
    table = pd.read_csv(tmp_path / "tables" / "t_tests.csv")
    assert is_printed(table["mean"][0], after("mean diff"))
