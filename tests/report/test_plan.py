"""What a plan can say, and that the analysis does it: contrasts, factors, families, rules."""

import csv
import json
import re
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_1samp

from tests.support import designs
from tests.support.places import ROOT
from tests.support.report import (
    HEAD,
    ITEMS,
    ONE_SCORE,
    WITHOUT_MODELS,
    Study,
    analysed,
    answers,
    build_report,
    carnegie_like,
    contents,
    foreign,
    manifest,
    planned_report,
    results_of,
    write_csv,
)
from vrcomfort.cli import main
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.records import QuestionnaireRow
from vrcomfort.report.build import choose_plan
from vrcomfort.report.derived_plan import plan_of
from vrcomfort.report.plan_files import AnalysisPlan as Plan
from vrcomfort.report.plan_files import find_plan, load_plan, read_plan, shipped_plans
from vrcomfort.report.results import analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study
from vrcomfort.report.words import p_value
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.signed_rank import signed_rank

SCORES = {f"P{i}": {"a": 3 + i, "b": 2 + i // 2} for i in range(8)}
POST_BASELINE = '[[contrasts]]\na_timepoint = "post"\nb_timepoint = "baseline"\n'


def reported(source: Path, lines: str) -> tuple[dict, str]:
    """Return results and page of a report."""
    summary = planned_report(source, out=source.parent / "o", lines=lines)
    return results_of(summary), summary.index.read_text("utf-8")


def kinds(results: dict) -> list[str]:
    return [found["kind"] for found in results["deviations"]]


def timed(path: Path, scores: dict[str, dict[str, int]], condition: str = "only") -> Path:
    """One file with a timepoint: participant → timepoint → sum of answers."""
    rows = [
        {"participant": who, "condition": condition, "timepoint": when, "item": item, "response": n}
        for who, moments in scores.items()
        for when, total in moments.items()
        for item, n in answers(total).items()
    ]
    write_csv(path, ("participant", "condition", "timepoint", "item", "response"), rows)
    return path


PRE_POST = {f"P{i}": {"baseline": i % 3, "post": 2 + i} for i in range(8)}


# --- Derived, and passed back -------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pairs", "before and after", "a protocol's"])
def test_the_plan_beside_a_report_gives_the_same_report(tmp_path, kind):
    source = tmp_path / "questionnaires.csv"
    if kind == "pairs":
        foreign(source, {**SCORES, "P\x7f “8”": {"a": 2, "b": 3}})
    elif kind == "before and after":
        timed(source, PRE_POST)
    else:
        source = carnegie_like(tmp_path / "study").folder
    build_report(source, out=tmp_path / "one")
    build_report(source, plan=tmp_path / "one" / "plan.toml", out=tmp_path / "two")
    assert contents(tmp_path / "one") == contents(tmp_path / "two")
    build_report(source, plan=tmp_path / "one" / "plan.toml", out=tmp_path / "one")
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


def test_one_condition_is_compared_with_the_baseline_of_each_exposure(tmp_path):
    results = analysed(timed(tmp_path / "questionnaires.csv", PRE_POST))
    test = results["tests"][0]
    assert (test["a"], test["b"], test["n"]) == ("post", "baseline", 8)
    raw = {n: sum(v * len(_loads(i)) for i, v in answers(n).items()) for n in range(10)}
    differences = [raw[2 + i] - raw[i % 3] for i in range(8)]
    assert test["p"] == pytest.approx(signed_rank(differences).p)
    mean = sum(differences) / 8 * 3.74
    assert test["descriptives"]["difference"]["mean"] == pytest.approx(mean)
    (post,) = (
        d for d in results["descriptives"]
        if (d["by"], d["level"], d["outcome"]) == ("timepoint", "post", "T")
    )  # fmt: skip
    assert post["mean"] == pytest.approx(3.74 * sum(raw[2 + i] for i in range(8)) / 8)


@pytest.mark.parametrize("kept", [("baseline", "post"), ("post",)])
def test_the_page_of_one_condition_has_its_means(tmp_path, kept):
    scores = {who: {when: found[when] for when in kept} for who, found in PRE_POST.items()}
    file = timed(tmp_path / "questionnaires.csv", scores)
    results, page = reported(file, ONE_SCORE + POST_BASELINE * (len(kept) == 2))
    table = page[page.index("scores at each timepoint") :]
    table = table[: table.index("</table>")]
    rows = [d for d in results["descriptives"] if d["by"] == "timepoint"]
    assert [d["level"] for d in rows if d["outcome"] == "T"] == [*kept]
    for row in rows:
        assert f"<td>{row['mean']:.2f}</td><td>{row['sd']:.2f}</td>" in table
    assert ("Comparisons of timepoints are of raw scores" in page) == (len(kept) == 2)
    assert ("no baseline questionnaire" in page) == (len(kept) == 1)


def test_raw_scores_that_a_plan_asks_for_are_not_for_want_of_a_baseline(tmp_path):
    file = timed(tmp_path / "questionnaires.csv", PRE_POST)
    results, page = reported(file, f'{ONE_SCORE}scores = "raw"\n')
    assert results["score_basis"] == "raw_post"
    assert "raw scores after exposure, as the plan asks" in page
    assert "no baseline questionnaire" not in page


def _loads(item: str) -> list[str]:
    scales = shipped_instruments()["ssq"].scales
    return [s.name for s in scales if item in {term.item for term in s.terms}]


def test_a_loss_between_before_and_after_is_told(tmp_path):
    moments = {who: dict(scores) for who, scores in PRE_POST.items()}
    del moments["P6"]["baseline"], moments["P7"]["post"]
    file = timed(tmp_path / "questionnaires.csv", moments)
    results = analysed(file, ONE_SCORE + POST_BASELINE)
    assert results["tests"][0]["n"] == 6
    assert "2 of 8 participants are not in the tests of post and baseline" in results["notices"][0]


def test_derived_timepoints_have_the_words_of_the_data(tmp_path):
    moments = {who: {"pre": m["baseline"], "after": m["post"]} for who, m in PRE_POST.items()}
    plan = plan_of(read_study(timed(tmp_path / "questionnaires.csv", moments)))
    assert (plan.baseline_timepoint, plan.exposure_timepoint) == ("pre", "after")
    assert plan.scores == "difference_from_baseline"


@pytest.mark.parametrize(("scenes", "factor"), [(1, []), (2, ["scene"])])
def test_a_derived_plan_has_scenes_as_a_factor_where_there_are_two(tmp_path, scenes, factor):
    rows = [
        {"participant": f"P{n}", "trial": trial, "condition": condition, "scene": f"s{scene}",
         "item": item, "response": response}
        for n in range(3)
        for trial, (condition, scene) in enumerate(product("ab", range(scenes)), start=1)
        for item, response in answers(n).items()
    ]  # fmt: skip
    write_csv(tmp_path / "questionnaires.csv", tuple(rows[0]), rows)
    plan = plan_of(read_study(tmp_path))
    assert [each.name for each in plan.anova] == ["condition", *factor]


def test_totals_are_adjusted_apart_from_what_they_are_summed_from(tmp_path):
    results = analysed(foreign(tmp_path / "questionnaires.csv", SCORES))
    tests = {test["outcome"]: test for test in results["tests"]}
    assert tests["T"]["p_holm"] == tests["T"]["p"]
    parts = holm([tests[name]["p"] for name in "NOD"])
    assert [tests[name]["p_holm"] for name in "NOD"] == pytest.approx(parts)
    assert [(f["name"], f["size"]) for f in results["families"]] == [("total", 1), ("subscales", 3)]


CROSSED = {f"{a}_{b}": {"blur": a, "streaks": b} for a in ("off", "dof") for b in ("off", "on")}


def crossed(folder: Path, met: Callable[[int], list[str]]) -> Path:
    """Write a study of a protocol with two crossed factors; participant → their conditions."""
    study, rng = Study(folder), np.random.default_rng(4)
    settings = {"conditions": [{"name": name, "levels": of} for name, of in CROSSED.items()]}
    for i in range(12):
        totals = {name: int(rng.integers(9)) + 4 * name.startswith("dof") for name in met(i)}
        exposures = [(name, "room", total) for name, total in totals.items()]
        where = study.session(f"P{i}", 1, 0, exposures)
        text = manifest(f"P{i}", settings=settings)
        (where / "manifest.json").write_text(text, encoding="utf-8")
    return folder


def test_crossed_factors_are_tested_by_their_effects(tmp_path):
    folder = crossed(tmp_path / "study", lambda _: list(CROSSED))
    summary = build_report(folder, out=tmp_path / "o")
    results, page = results_of(summary), summary.index.read_text("utf-8")
    scores = pd.read_csv(tmp_path / "o/tables/scores.csv")
    wide = scores.pivot_table(index="participant", columns="condition", values="T")[list(CROSSED)]
    effects = {each["effect"]: each for each in results["anova"][0]["effects"]}
    assert list(effects) == ["blur", "streaks", "blur × streaks"]
    signs = {"blur": (1, 1, -1, -1), "streaks": (1, -1, 1, -1), "blur × streaks": (1, -1, -1, 1)}
    p_values = [ttest_1samp(wide @ np.array(signs[name]), 0).pvalue for name in effects]
    assert [each["p"] for each in effects.values()] == pytest.approx(p_values)
    adjusted = [each["p_holm"] for each in effects.values()]
    assert adjusted == pytest.approx(holm(p_values))
    for name, p, other in zip(effects, p_values, adjusted, strict=True):
        line = next(each for each in page.split("<tr>") if f"<td>{name}</td>" in each)
        cells = re.findall(r">([^<]*|<.[^<]*)</td>", line)
        assert cells[3:5] == [p_value(p), p_value(other)]
    pairs = {(test["a"], test["b"]) for test in results["tests"]}
    assert pairs == {("dof_off", "dof_on"), ("dof_off", "off_off"), ("dof_on", "off_on"),
                     ("off_off", "off_on")}  # fmt: skip
    said = "an effect of blur", "no effect of streaks", "no interaction of blur and streaks"
    assert sorted(page.index(f"{each} was shown") for each in said) == [
        page.index(f"{each} was shown") for each in said
    ]


def test_crossed_factors_are_between_people_who_met_one_condition_each(tmp_path):
    folder = crossed(tmp_path / "study", lambda i: [list(CROSSED)[i % 4]])
    anova = analysed(folder)["anova"][0]
    assert anova["between"] == ["blur", "streaks"]
    assert [each["effect"] for each in anova["effects"]] == ["blur", "streaks", "blur × streaks"]


@pytest.mark.parametrize("kept", [3, 2])
def test_conditions_are_compared_where_not_every_cell_was_met(tmp_path, kept):
    folder = crossed(tmp_path / "study", lambda i: list(CROSSED)[i % 2 : i % 2 + kept])
    assert [factor.name for factor in plan_of(read_study(folder)).anova] == ["condition"]


# --- Contrasts ----------------------------------------------------------------------------------


def test_conditions_are_compared_at_any_timepoint(tmp_path):
    study = Study(tmp_path / "study")
    for i in range(6):
        for number, condition in ((1, "a"), (2, "b")):
            folder = study.session(f"P{i}", number, 1, [(condition, "room", 3 + i * number)])
            same = {"participant": f"P{i}", "session": number, "timepoint": "recovery"}
            with (folder / "questionnaires.csv").open("a", newline="") as stream:
                writer = csv.DictWriter(stream, QuestionnaireRow.columns(), lineterminator="\n")
                for item, response in answers(i + number).items():
                    writer.writerow(
                        {**same, "instrument": "ssq", "item": item, "response": response}
                    )
    results = analysed(
        study.folder,
        f'{ONE_SCORE}[[contrasts]]\na = "a"\nb = "b"\na_timepoint = "recovery"\n'
        'b_timepoint = "recovery"\n[[contrasts]]\na = "b"\na_timepoint = "recovery"\n'
        'b = "b"\nb_timepoint = "baseline"\n',
    )
    recovery, back = results["tests"]
    assert (recovery["a"], recovery["b"], recovery["n"]) == ("a at recovery", "b at recovery", 6)
    assert (recovery["w_plus"], recovery["w_minus"]) == (0, 21), "b has one more in each"
    assert results["labels"]["b at baseline"] == "b, baseline"
    assert back["w_minus"] == 0


def test_each_contrast_has_its_side(tmp_path):
    results, page = reported(
        foreign(tmp_path / "questionnaires.csv", SCORES),
        f'{ONE_SCORE}[[contrasts]]\na = "a"\nb = "b"\nalternative = "greater"\n'
        '[[contrasts]]\na = "b"\nb = "a"\n',
    )
    one, two = results["tests"]
    assert (one["alternative"], two["alternative"]) == ("greater", "two-sided")
    assert one["shift"]["high"] is None, "a one-sided test has a one-sided bound"
    assert one["p"] == pytest.approx(two["p"] / 2)
    assert [" (greater)</td>" in page, " (two-sided)</td>" in page] == [True, True]
    assert "<i>p</i>: as each comparison says" in page


def test_a_scale_of_usability_is_not_read_as_discomfort(tmp_path):
    items = [item.name for item in shipped_instruments()["sus"].items]
    rows = [
        {"participant": f"P{n}", "condition": c, "instrument": "sus", "item": item, "response": r}
        for n in range(6)
        for c, r in (("a", 1), ("b", 1 + n % 2))
        for item in items
    ]
    file = tmp_path / "questionnaires.csv"
    write_csv(file, ("participant", "condition", "instrument", "item", "response"), rows)
    results, page = reported(file, WITHOUT_MODELS)
    assert "discomfort" not in page
    assert "<h2>Questions</h2>" in page
    assert "ymptom<" not in page
    above = {row["condition"]: row["above"] for row in results["symptoms"]}
    assert above == {"a": 0, "b": 3}, "1 is the lowest answer"


def test_the_side_on_the_page_is_that_of_the_tests(tmp_path):
    contrast = f'{ONE_SCORE}[[contrasts]]\na = "a"\nb = "b"\nalternative = "less"\n'
    _, page = reported(foreign(tmp_path / "questionnaires.csv", SCORES), contrast)
    assert "<i>p</i>: less, exact" in page
    assert "<h2>Symptoms</h2>" in page
    assert "one-sided (lower scores under the first condition)" in page


def test_asymptotic_p_values_are_those_of_z(tmp_path):
    results = analysed(
        foreign(tmp_path / "questionnaires.csv", SCORES),
        f'{ONE_SCORE}p_value = "asymptotic"\n',
    )
    test = results["tests"][0]
    assert (test["method"], test["p_exact"], test["p"]) == (
        "asymptotic",
        None,
        test["p_asymptotic"],
    )


def test_what_is_compared_with_itself_or_with_nothing_is_an_error():
    for text, words in (
        ('contrasts = [{ a = "x", b = "x" }]', "condition `x` is compared with itself"),
        ('contrasts = [{ a_timepoint = "post" }]', "timepoint `post` is compared with itself"),
        ('contrasts = [{ a = "x" }]', "`b` is missing"),
    ):
        with pytest.raises(InputError, match=words):
            read_plan(HEAD + text, None)


# --- Factors ------------------------------------------------------------------------------------


@pytest.fixture
def grouped(tmp_path) -> Path:
    """Nine people in two groups of unequal size, with ages; one has neither."""
    folder = tmp_path / "grouped"
    scores = {f"P{i}": {"a": 3 + i % 4, "b": 2 + (i * 7) % 5} for i in range(10)}
    foreign(folder / "questionnaires.csv", scores)
    lines = [f"P{i},{'novice' if i < 6 else 'expert'},{20 + 3 * i}" for i in range(9)]
    (folder / "participants.csv").write_text(
        "participant,skill,age\n" + "\n".join(lines) + "\nP9,,\n"
    )
    return folder


def test_factors_between_participants_come_from_the_participants_file(grouped):
    text = 'outcomes = ["T"]\n[[anova]]\nname = "condition"\ncolumn = "condition"\n'
    text += '[[anova]]\nname = "skill"\ncolumn = "skill"\n'
    three = analysed(grouped, text)["anova"][0]
    assert [e["effect"] for e in three["effects"]] == ["skill", "condition", "skill × condition"]
    assert (three["n"], three["excluded"], three["between"]) == (9, ["P9"], ["skill"])
    two = analysed(grouped, 'sums_of_squares = "II"\n' + text)["anova"][0]
    f = {kind: [e["f"] for e in found["effects"]] for kind, found in (("2", two), ("3", three))}
    assert f["2"][0] == pytest.approx(f["3"][0])
    assert f["2"][2] == pytest.approx(f["3"][2])
    assert f["2"][1] != pytest.approx(f["3"][1]), "groups of 6 and 3 weigh differently"


def test_conditions_of_different_people_are_compared_between_them(tmp_path):
    scores = {f"P{i}": {"ab"[i % 2]: 2 + i // 2 + 3 * (i % 2)} for i in range(12)}
    results = analysed(foreign(tmp_path / "questionnaires.csv", scores))
    anova = results["anova"][0]
    assert (anova["n"], anova["between"]) == (12, ["condition"])
    assert [e["effect"] for e in anova["effects"]] == ["condition"]
    assert results["tests"] == [] == results["mixed_models"]
    first = results["comparisons"][0]
    assert (first["test"], first["n_a"], first["n_b"]) == ("mann_whitney", 6, 6)


def test_pairs_of_different_people_are_told_what_to_write(tmp_path):
    scores = {f"P{i}": {"ab"[i % 2]: 2 + i} for i in range(12)}
    text = f'{ONE_SCORE}[[contrasts]]\na = "a"\nb = "b"\n'
    row = analysed(foreign(tmp_path / "questionnaires.csv", scores), text)["tests"][0]
    assert 'write between = "condition"' in row["not_tested"]


def test_nobody_of_three_groups_is_missing_from_the_tests_of_the_others(tmp_path):
    scores = {f"P{i:02d}": {"abc"[i % 3]: 2 + i} for i in range(15)}
    summary = build_report(foreign(tmp_path / "questionnaires.csv", scores), out=tmp_path / "o")
    results, page = results_of(summary), summary.index.read_text("utf-8")
    people = results["participants"]
    assert len(people["analysed"]) == 15
    assert people["left_out"] == people["in_some_tests"] == []
    assert results["flow"][-1]["in_every_test"] == 15
    for pairs in (
        "igned-rank tests do not",
        "rely on the signed",
        "worst-rank",
        "No test was made",
    ):
        assert pairs not in page


def test_groups_that_are_the_conditions_are_one_factor(tmp_path):
    folder = designs.between_groups(tmp_path / "study")
    path = folder / "questionnaires.csv"
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    of = pd.read_csv(folder / "participants.csv").set_index("participant")["group"]
    after = table["timepoint"] == "post"
    table.loc[after, "condition"] = table.loc[after, "participant"].map(of)
    table.to_csv(path, index=False)
    assert [factor.name for factor in plan_of(read_study(folder)).anova] == ["condition"]


def test_covariates_are_in_the_mixed_model(grouped):
    text = 'outcomes = ["T"]\nmixed_model = ["condition", "skill"]\ncovariates = ["age"]\n'
    model = analysed(grouped, text)["mixed_models"][0]
    assert set(model["omnibus"]) == {"condition", "skill", "age"}
    assert model["n_participants"] == 9


def test_columns_that_are_not_there_have_a_near_one(grouped):
    for text, words in (
        ('mixed_model = ["condition", "skil"]', "`skil` is not a column .* did you mean `skill`"),
        ('covariates = ["skill"]', "covariate `skill` of participant P0 is `novice`"),
    ):
        with pytest.raises(InputError, match=words):
            analysed(grouped, text)


def test_time_is_a_factor_within_participants(tmp_path):
    results = analysed(
        timed(tmp_path / "questionnaires.csv", PRE_POST),
        'outcomes = ["T"]\nmixed_model = []\n[[anova]]\nname = "time"\ncolumn = "timepoint"\n',
    )
    anova = results["anova"][0]
    assert anova["factors"] == {"time": ["baseline", "post"]}
    assert anova["n"] == 8


def test_effects_of_the_anova_can_be_in_a_family(tmp_path):
    results = analysed(
        foreign(tmp_path / "questionnaires.csv", SCORES),
        'outcomes = ["T", "N"]\nmixed_model = []\n'
        '[[families]]\nname = "all"\noutcomes = ["T", "N"]\n'
        'analyses = ["tests", "anova"]\n',
    )
    effects = [e for found in results["anova"] for e in found["effects"]]
    raw = [row["p"] for row in (*results["tests"], *effects)]
    assert [row["p_holm"] for row in (*results["tests"], *effects)] == pytest.approx(holm(raw))
    assert results["families"] == [{"name": "all", "method": "holm", "size": 4}]


# --- Who is in ----------------------------------------------------------------------------------


def test_rules_exclude_and_each_exclusion_is_listed(tmp_path):
    study = carnegie_like(tmp_path / "study")
    rules = (
        f'participants = 8\n{ONE_SCORE}[[contrasts]]\na = "dof_off"\nb = "dof_on"\n'
        '[[exclusions]]\nname = "ill"\nreason = "had a cold"\nparticipants = ["P02", "P99"]\n'
        '[[exclusions]]\nname = "sick before"\nscore = "T"\ntimepoint = "baseline"\nabove = 10.0\n'
        '[[exclusions]]\nname = "short"\ntrial = "length_s"\nbelow = 50.0\nremoves = "exposure"\n'
    ).replace('"sick before"', '"sick_before"')
    results = analysed(study.folder, rules)
    found = {(row["rule"], row["participant"]): row for row in results["exclusions"]}
    assert found["ill", "P02"]["reason"] == "had a cold"
    assert {who for rule, who in found if rule == "sick_before"} == {"P03", "P06"}
    assert found["sick_before", "P03"]["reason"] == "Total severity at baseline is 14.96"
    assert found["short", "P08"]["what"] == "session 2, exposure 1"
    assert results["participants"]["analysed"] == ["P01", "P04", "P07"]
    left = {row["participant"]: row["reason"] for row in results["participants"]["left_out"]}
    assert left["P02"] == "rule ill (had a cold)"
    assert [rule["excluded"] for rule in results["exclusion_rules"]] == [1, 2, 2]
    assert "exclusion_not_found" in kinds(results)


def test_rules_that_cannot_work_are_errors():
    for text, words in (
        ('name = "x"', "names nothing to go by"),
        ('name = "x"\nscore = "T"', "has no limit"),
        ('name = "x"\nscore = "T"\ncolumn = "age"\nabove = 3', "has score and column; give one of"),
        ('name = "x"\nscore = "Q"\nabove = 3', "`Q` is no score"),
        ('name = "x"\nscore = "T"\nequals = ["3"]', "goes by a number"),
        ('name = "x"\ncolumn = "age"\nabove = 3\nremoves = "exposure"', "belongs to no exposure"),
        ('name = "x"\ntrial = "speed"\nabove = 3', "should be"),
    ):
        with pytest.raises(InputError, match=words):
            read_plan(f"{HEAD}[[exclusions]]\n{text}\n", None)


def test_withdrawals_are_treated_as_the_plan_says(tmp_path):
    study = carnegie_like(tmp_path / "study")
    contrast = '[[contrasts]]\na = "dof_off"\nb = "dof_on"\n'
    found = {
        kind: analysed(study.folder, f'{ONE_SCORE}withdrawals = "{kind}"\n{contrast}')
        for kind in ("complete_pairs", "available_pairs", "worst_rank")
    }
    n = {kind: results["tests"][0]["n"] for kind, results in found.items()}
    assert n == {"complete_pairs": 6, "available_pairs": 7, "worst_rank": 8}
    ranked = found["worst_rank"]["tests"][0]
    assert ranked["ranked_worst"] == ["P05", "P08"]
    line = next(
        s for s in found["complete_pairs"]["sensitivity"] if "worst outcome" in s["analysis"]
    )
    assert ranked["p"] == line["p"]
    shift, of_who_stayed = ranked["shift"], found["complete_pairs"]["tests"][0]["shift"]
    assert shift["estimate"] == of_who_stayed["estimate"]
    assert (shift["low"], shift["high"]) == (None, None)  # theirs are those of another test


def test_missing_items_are_prorated_where_the_plan_says(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", SCORES)
    file.write_text(file.read_text().replace("P7,a,burping,0", "P7,a,burping,"))
    nausea_alone = f'outcomes = ["N"]\n{WITHOUT_MODELS}'
    assert analysed(file, nausea_alone)["tests"][0]["n"] == 7
    test = analysed(file, f'{nausea_alone}missing_items = "prorate"\n')["tests"][0]
    assert test["n"] == 8
    nausea = sum(answers(10)[item] for item in ITEMS if "N" in _loads(item))
    assert test["descriptives"]["a"]["maximum"] == pytest.approx(9.54 * nausea * 7 / 6)
    strict = f'{nausea_alone}missing_items = "prorate"\nmin_answered = 1.0\n'
    assert analysed(file, strict)["tests"][0]["n"] == 7


# --- Outcomes -----------------------------------------------------------------------------------


def test_outcomes_of_several_instruments_are_analysed_together(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", SCORES, instrument="ssq")
    ratings = [f"P{i},{c},fms,{i + (c == 'a')},fms" for i in range(8) for c in "ab"]
    file.write_text(file.read_text() + "\n".join(ratings) + "\n")
    results = analysed(file, f'outcomes = ["T", "fms", "misc"]\n{WITHOUT_MODELS}')
    assert [test["outcome"] for test in results["tests"]] == ["T", "fms"]
    assert (results["tests"][1]["n"], results["tests"][1]["w_minus"]) == (8, 0)
    assert [each["instrument"] for each in results["outcomes"]] == ["ssq", "fms"]
    assert "outcome_not_found" in kinds(results)
    alone = analysed(file, f'outcomes = ["fms"]\n{WITHOUT_MODELS}')
    assert [test["n"] for test in alone["tests"]] == [8]


def test_a_plan_without_any_outcome_in_the_data_is_an_error(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", SCORES)
    with pytest.raises(InputError, match=r"no outcome of the plan \(misc: .* not answered"):
        analysed(file, 'outcomes = ["misc"]\n')


def test_answers_of_unknown_instruments_are_told(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", SCORES, instrument="ssq")
    file.write_text(file.read_text() + "P1,a,x,3,presence\n")
    assert "1 answers of `presence` are not used" in read_study(file).warnings[0]


# --- Deviations ---------------------------------------------------------------------------------


def test_a_plan_that_was_followed_has_no_deviations(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", SCORES)
    plan = 'participants = 8\nscores = "raw"\noutcomes = ["T"]\nmixed_model = ["condition"]\n'
    plan += '[[anova]]\nname = "condition"\ncolumn = "condition"\n'
    assert analysed(file, plan)["deviations"] == []


def test_deviations_are_told(tmp_path):
    study = carnegie_like(tmp_path / "study")
    study.people[1] |= {"status": "excluded", "note": "fell asleep"}
    study.person("P01", "off")
    results = analysed(
        study.folder,
        'participants = 20\noutcomes = ["T"]\nmixed_model = []\n'
        '[[anova]]\nname = "group"\ncolumn = "group"\n'
        '[[anova]]\nname = "blur"\ncolumn = "condition"\n',
    )
    found = {each["kind"]: each for each in results["deviations"]}
    assert found["fewer_participants"]["text"] == "20 participants were planned; 8 were there"
    assert found["excluded_without_rule"]["participants"] == ["P02"]
    assert "group has one level" in found["factor_left_out"]["text"]
    ruled = analysed(
        study.folder,
        f'{ONE_SCORE}[[exclusions]]\nname = "asleep"\nparticipants = ["P02"]\n',
    )
    assert "excluded_without_rule" not in kinds(ruled)


def test_timepoints_that_no_questionnaire_has_are_told(tmp_path):
    results = analysed(
        timed(tmp_path / "questionnaires.csv", PRE_POST),
        ONE_SCORE + POST_BASELINE.replace("baseline", "basline"),
    )
    found = {each["kind"]: each["text"] for each in results["deviations"]}
    assert "`basline` (did you mean `baseline`?)" in found["timepoint_not_found"]
    assert results["tests"][0]["not_tested"].startswith("0 complete pairs")


def test_more_pairs_than_the_exact_test_takes_are_a_deviation(tmp_path):
    rows = [f"P{i},{c},fms,{(i * n) % 7},fms" for i in range(520) for c, n in (("a", 1), ("b", 5))]
    file = tmp_path / "questionnaires.csv"
    file.write_text("\n".join(["participant,condition,item,response,instrument", *rows, ""]))
    results = analysed(file, f'outcomes = ["fms"]\nscores = "raw"\n{WITHOUT_MODELS}')
    assert kinds(results) == ["other_method"]
    assert "asymptotic with more than 500 pairs" in results["deviations"][0]["text"]


def test_the_hash_is_that_of_the_text(tmp_path):
    study = read_study(foreign(tmp_path / "questionnaires.csv", SCORES))
    one, two = (read_plan(f"{HEAD}{ONE_SCORE}{more}", None) for more in ("", "# a word\n"))
    assert analyse(study, one)[0].plan.sha256 == one.sha256 != two.sha256


def test_every_seed_is_recorded(tmp_path):
    results = analysed(foreign(tmp_path / "questionnaires.csv", SCORES), ONE_SCORE)
    assert {seed["what"] for seed in results["seeds"]} == {"bootstrap-t of means"}
    assert all(isinstance(seed["seed"], int) for seed in results["seeds"])


# --- Shipped ------------------------------------------------------------------------------------


def test_shipped_plans_go_by_name(tmp_path):
    names = [plan.name for plan in shipped_plans()]
    assert {"carnegie_2015", "carnegie_2015_as_printed", "motion_blur_2020"} <= set(names)
    assert load_plan(find_plan("motion_blur_2020")).name == "motion_blur_2020"
    with pytest.raises(InputError, match="did you mean `carnegie_2015`"):
        find_plan("carnegy_2015")


def test_the_template_and_the_page_have_every_key():
    text = find_plan("default").read_text("utf-8")
    keys = set(re.findall(r"^(?:# )?(\w+) += ", text, re.MULTILINE))
    keys |= set(re.findall(r"^\[\[?(\w+)\]\]?$", text, re.MULTILINE))
    assert set(Plan.model_fields) <= keys
    page = (ROOT / "docs/plans.md").read_text("utf-8")
    told = set(re.findall(r"`\[*(\w+)\]*`", page))
    assert set(Plan.model_fields) - told <= {"name", "title", "citation", "note"}


def test_the_printed_plan_has_the_printed_convention(tmp_path):
    study = carnegie_like(tmp_path / "study")
    plan = load_plan(find_plan("carnegie_2015_as_printed"))
    tests = as_json(analyse(read_study(study.folder), plan)[0])["tests"]
    assert {(t["alternative"], t["method"], t["p_holm"]) for t in tests} == {
        ("greater", "asymptotic", None)
    }
    ours = choose_plan(read_study(study.folder), None)
    assert (ours.name, ours.alternative, ours.p_value) == ("carnegie_2015", "two-sided", "exact")


def test_each_mode_of_motion_blur_is_compared_with_none(tmp_path):
    modes = ("off", "full", "objects", "translation", "translation_faded")
    scores = {f"P{i}": {m: (i * (k + 3)) % 9 for k, m in enumerate(modes)} for i in range(6)}
    file = foreign(tmp_path / "questionnaires.csv", scores)
    plan = load_plan(find_plan("motion_blur_2020")).model_copy(update={"mixed_model": []})
    results = as_json(analyse(read_study(file), plan)[0])
    total = [test for test in results["tests"] if test["outcome"] == "T"]
    assert [(test["a"], test["b"]) for test in total] == [("off", mode) for mode in modes[1:]]
    assert {family["name"]: family["size"] for family in results["families"]} == {
        "total": 4, "subscales": 12,
    }  # fmt: skip


def test_a_session_with_all_conditions_is_compared_before_and_after(tmp_path):
    file = timed(tmp_path / "questionnaires.csv", PRE_POST, condition="")
    results = as_json(analyse(read_study(file), load_plan(find_plan("mantiuk_2011")))[0])
    assert [(t["a"], t["b"], t["n"]) for t in results["tests"]][:1] == [("post", "baseline", 8)]
    assert results["conditions"] == []
    assert "" not in json.dumps(results["labels"]).split('"')[1::4]


# --- On the command line ------------------------------------------------------------------------


@pytest.mark.slow
def test_shipped_plans_are_listed_and_taken_by_name(tmp_path, capsys, monkeypatch):
    def run(*arguments: object) -> int:
        monkeypatch.setattr("sys.argv", ["vrcomfort", "report", *map(str, arguments)])
        try:
            main()
        except SystemExit as ended:
            return int(ended.code or 0)
        return 0

    assert run("--list-plans") == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == [plan.name for plan in shipped_plans()]
    study, out = carnegie_like(tmp_path / "study").folder, tmp_path / "out"
    assert run(study, "--plan", "carnegie_2015_as_printed", "--out", out, "--quiet") == 0
    results = json.loads((out / "results.json").read_text("utf-8"))
    assert results["plan"]["name"] == "carnegie_2015_as_printed"
    text = find_plan("carnegie_2015_as_printed").read_text("utf-8")
    assert (out / "plan.toml").read_text("utf-8") == text
    deviations = (out / "tables/deviations.csv").read_text("utf-8")
    assert "20 participants were planned; 8 were there" in deviations
    capsys.readouterr()
    assert run(study, "--plan", "carnegy_2015", "--out", out) == 2
    assert "did you mean `carnegie_2015`?" in capsys.readouterr().err
