"""The public Python API: names, what they return, and the example notebook."""

from __future__ import annotations

import ast
import csv
import io
import json
import subprocess
import sys
import warnings
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import vrcomfort
from tests.support.places import ROOT
from tests.support.report import foreign
from vrcomfort import stats
from vrcomfort.api.simulation import simulate_sessions
from vrcomfort.cli import main
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.resources import data_folder
from vrcomfort.stats.anova import anova
from vrcomfort.stats.signed_rank import signed_rank

SSQ = [item.name for item in shipped_instruments()["ssq"].items]


def test_importing_the_package_loads_nothing_else():
    code = "import sys; before = set(sys.modules); import vrcomfort; print(*sys.modules - before)"
    code = code.replace("sys.modules - before", "set(sys.modules) - before")
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT
    )
    loaded = {name.partition(".")[0] for name in done.stdout.split()}
    assert loaded - set(sys.stdlib_module_names) == {"vrcomfort"}
    assert [name for name in done.stdout.split() if name.startswith("vrcomfort")] == ["vrcomfort"]


EVERY_MODULE_FIRST = """
import importlib, pkgutil, vrcomfort
for module in pkgutil.walk_packages(vrcomfort.__path__, "vrcomfort."):
    if not module.name.startswith("vrcomfort.headset.openxr"):
        importlib.import_module(module.name)
for package in (vrcomfort, vrcomfort.stats):
    for name in package.__all__:
        if name not in {"__version__", "stats"}:
            assert callable(getattr(package, name)), name
assert vrcomfort.stats.__name__ == "vrcomfort.stats"
"""


@pytest.mark.slow
def test_public_names_can_be_called_after_every_module_was_imported():
    done = subprocess.run(
        [sys.executable, "-c", EVERY_MODULE_FIRST],
        check=False, capture_output=True, text=True, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("package", [vrcomfort, stats])
def test_stubs_for_editors_have_the_public_names(package):
    stub = ast.parse(Path(package.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    names = {each.asname for node in stub.body if isinstance(node, ast.ImportFrom)
             for each in node.names}  # fmt: skip
    names |= {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
    assert names == set(package.__all__) <= set(dir(package))


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'reprot'"):
        vrcomfort.reprot  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'wilcoxn'"):
        stats.wilcoxn  # noqa: B018


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("api") / "study"
    return vrcomfort.simulate_study("smoke", folder, participants=3, seed=5)


def test_a_simulated_study_is_read_as_data_frames(study):
    again = vrcomfort.read_study(study.folder)
    assert list(again.participants["participant"]) == ["P01", "P02", "P03"]
    assert {"participant", "trial", "response"} <= set(again.ratings)
    with pytest.raises(vrcomfort.InputError, match="are recorded"):
        vrcomfort.simulate_study("smoke", study.folder, participants=3)
    with pytest.raises(vrcomfort.InputError, match="no such file or folder"):
        vrcomfort.read_study(study.folder / "elsewhere")


def test_scores_of_a_study_are_those_of_its_answers(study):
    scores = study.scores("ssq")
    answers = study.answers[study.answers["instrument"] == "ssq"]
    asked = answers.groupby(["participant", "trial", "timepoint"], dropna=False)["response"].sum()
    assert len(scores) == len(asked)
    assert "part" not in scores
    weights = {"total": 3.74, "nausea": 9.54, "oculomotor": 7.58, "disorientation": 13.92}
    for name, weight in weights.items():
        raw = scores[f"{name}_raw"]
        assert raw.dtype == "Int64"
        np.testing.assert_allclose(scores[name], raw.astype(float) * weight)
    by_hand = answers.pivot_table(
        index=["participant", "timepoint", "trial"], columns="item", values="response"
    )
    first = by_hand.loc[("P02", "post", 1)]
    row = scores[(scores["participant"] == "P02") & (scores["trial"] == 1)].iloc[0]
    given = {name: int(first[name]) for name in SSQ}
    expected = vrcomfort.score_answers(pd.DataFrame([given]), "ssq", coded_from=0).iloc[0]
    for name in weights:
        assert row[name] == expected[name]
    assert study.scores("vrsq").empty
    with pytest.raises(vrcomfort.InputError, match="no instrument `sqs`"):
        study.scores("sqs")


def test_a_table_that_names_no_questionnaire_is_scored_as_the_one_asked_for(tmp_path):
    lines = [f"P 1,on,{item},{place % 4}" for place, item in enumerate(SSQ)]
    file = tmp_path / "questionnaires.csv"
    file.write_text("\n".join(["participant,condition,item,response", *lines]))
    with pytest.warns(UserWarning, match="half-written"):
        assert vrcomfort.read_study(tmp_path).scores("ssq")["total"].isna().all()
    file.write_text("\n".join(["participant,condition,item,response", *lines, ""]))
    scores = vrcomfort.read_study(tmp_path).scores("ssq")
    assert scores["participant"].tolist() == ["P 1"]
    given = pd.DataFrame([dict(zip(SSQ, [0, 1, 2, 3] * 4, strict=True))])
    assert scores["total"].item() == vrcomfort.score_answers(given, "ssq")["total"].item()
    assert scores["session"].isna().all()
    with pytest.raises(vrcomfort.InputError, match=r"questionnaires\.csv, line \d+"):
        vrcomfort.read_study(file).scores("vrsq")


def test_a_report_is_written_of_a_study_and_a_plan(study, tmp_path):
    text = vrcomfort.load_plan("carnegie_2015").text
    (tmp_path / "plan.toml").write_text(text.replace("dof_off", "plain").replace("dof_on", "both"))
    plan = vrcomfort.load_plan(tmp_path / "plan.toml")
    notes = []
    summary = vrcomfort.write_report(
        study, tmp_path / "report", plan=plan, forms=(), note=notes.append
    )
    assert json.loads(summary.results.read_text())["plan"]["sha256"] == plan.sha256
    assert summary.participants == 3
    assert len(summary.headlines) == 5  # of four scores, and of the ratings
    assert notes == [*summary.warnings]


def answers(**changed):
    table = pd.DataFrame(np.arange(48).reshape(3, 16) % 4, columns=SSQ, dtype="float64")
    table.insert(0, "who", ["A", "B", "C"])
    for name, value in changed.items():
        table.loc[1, name] = value
    return table


def test_scores_are_those_of_the_command(tmp_path, monkeypatch, capsys):
    file = tmp_path / "answers.csv"
    answers().astype(dict.fromkeys(SSQ, "int64")).to_csv(file, index=False)
    monkeypatch.setattr("sys.argv", ["vrcomfort", "score", str(file)])
    with pytest.raises(SystemExit):
        main()
    printed = pd.DataFrame(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    for given in (answers(), file):
        scored = vrcomfort.score_answers(given)
        assert list(scored) == list(printed)
        assert scored["total"].tolist() == printed["total"].astype(float).tolist()
        assert scored["who"].tolist() == ["A", "B", "C"]
        assert scored["total_raw"].dtype == "Int64"


def test_wrong_answers_are_named_by_line_and_column():
    with pytest.raises(vrcomfort.InputError, match=r"answers\.csv, line 3, column nausea"):
        vrcomfort.score_answers(answers(nausea=7), "ssq")
    notes = []
    kept = vrcomfort.score_answers(
        answers(nausea=np.nan), "ssq", skip_incomplete=True, note=notes.append
    )
    assert kept["who"].tolist() == ["A", "C"]
    assert notes == [
        "answers.csv: 1 of 3 questionnaires lack answers and were left out; they begin in line: 3"
    ]


@pytest.fixture
def tidy():
    random = np.random.default_rng(3)
    people = [f"P{n}" for n in range(1, 13)]
    rows = [
        {"who": name, "seen": seen, "group": "ab"[n % 2], "total": 3.74 * random.integers(0, 12)}
        for n, name in enumerate(people)
        for seen in ("off", "on", "max")
    ]
    return pd.DataFrame(rows)


def test_wilcoxon_is_the_signed_rank_test_of_whole_steps(tidy):
    two = tidy[tidy["seen"] != "max"]
    (row,) = stats.wilcoxon(two, dv="total", within="seen", subject="who").to_dict("records")
    wide = np.rint(two.pivot_table(index="who", columns="seen", values="total") / 3.74).astype(int)
    test = signed_rank(wide["off"] - wide["on"], 3.74)
    assert (row["A"], row["B"], row["W_plus"], row["ties"]) == ("off", "on", test.w_plus, test.ties)
    assert (row["p"], row["p_holm"]) == (test.p, test.p)
    found = [row[name] for name in ("shift", "low", "high", "rank_biserial", "rb_low", "rb_high")]
    assert found == pytest.approx(
        [test.shift.estimate, test.shift.low, test.shift.high,
         test.effect.estimate, test.effect.low, test.effect.high]
    )  # fmt: skip
    every = stats.wilcoxon(tidy, dv="total", within="seen", subject="who")
    assert len(every) == 3
    assert every["p_holm"].tolist() == stats.holm(every["p"]).tolist()


def test_missing_values_are_excluded_and_counted(tidy):
    tidy.loc[0, "total"] = np.nan
    first = stats.wilcoxon(tidy, dv="total", within="seen", subject="who").iloc[-1]
    assert (first["A"], first["B"], first["n"], first["excluded"]) == ("off", "on", 11, 1)
    table = stats.rm_anova(tidy, dv="total", within="seen", subject="who")
    assert (table["n"].item(), table["excluded"].item()) == (11, 1)
    assert stats.friedman(tidy, dv="total", within="seen", subject="who")["n"].item() == 11


def test_two_values_in_a_cell_and_scales_without_a_step_are_refused(tidy):
    twice = pd.concat([tidy, tidy.iloc[:1]])
    with pytest.raises(vrcomfort.InputError, match="two values of 'total' under one level"):
        stats.wilcoxon(twice, dv="total", within="seen", subject="who")
    tidy["total"] /= 3
    with pytest.raises(vrcomfort.InputError, match="give its step as `unit`"):
        stats.wilcoxon(tidy, dv="total", within="seen", subject="who")
    unit = stats.wilcoxon(tidy, dv="total", within="seen", subject="who", unit=3.74 / 3)
    assert len(unit) == 3


def cells() -> pd.DataFrame:
    rows = [(who, seen, who + len(seen)) for who in range(6) for seen in ("on", "off")]
    return pd.DataFrame(rows, columns=["who", "seen", "total"])


NAMES = {"dv": "total", "within": "seen", "subject": "who"}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"dv": "totl"}, "`dv`: there is no column 'totl'; did you mean `total`"),
        ({"subject": "person"}, "`subject`: there is no column 'person'; known here: seen, total"),
        ({"within": "total"}, "column 'total' is named twice"),
        ({"within": 3}, "`within` should be the name of a column, got 3"),
        ({"dv": ["total"]}, "`dv` should be the name of a column"),
    ],
)
@pytest.mark.parametrize("test", [stats.wilcoxon, stats.ttest, stats.rm_anova, stats.icc])
def test_columns_that_are_not_there_are_named(test, change, says):
    with pytest.raises(vrcomfort.InputError, match=says):
        test(cells(), **NAMES | change)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (["some"] * 12, "should hold numbers, not 'some'"),
        (pd.date_range("2026-01-01", periods=12), "should hold numbers, not .*2026"),
        ([1j] * 12, "should hold numbers"),
        ([np.inf, *range(11)], "infinite"),
    ],
)
def test_values_that_are_no_numbers_are_refused(values, says):
    for test in (stats.wilcoxon, stats.rm_anova, stats.friedman):
        with pytest.raises(vrcomfort.InputError, match=says):
            test(cells().assign(total=values), **NAMES)


def test_numbers_of_any_type_are_the_same_numbers():
    expected = stats.ttest(cells(), **NAMES)
    for kind in (str, "Int64", "Float64", "int8", object):
        found = stats.ttest(cells().astype({"total": kind}), **NAMES)
        pd.testing.assert_frame_equal(found, expected)


@pytest.mark.parametrize(
    ("choice", "says"),
    [
        ({"alternative": "bigger"}, "`alternative` cannot be 'bigger'; known here: greater"),
        ({"zeros": "prat"}, "did you mean `pratt`"),
        ({"p_value": "x"}, "`p_value` cannot be 'x'"),
        ({"confidence": 95}, "`confidence` cannot be 95; write a number such as 0.95"),
        ({"unit": 0}, "`unit` cannot be 0"),
    ],
)
def test_choices_that_do_not_exist_are_refused(choice, says):
    with pytest.raises(vrcomfort.InputError, match=says):
        stats.wilcoxon(cells(), **NAMES | choice)


def test_a_reference_that_no_row_has_is_named():
    with pytest.raises(vrcomfort.InputError, match="'seen' is never 'onn'; did you mean `on`"):
        stats.mixed_model(
            cells(), dv="total", subject="who", factors="seen", references={"seen": "onn"}
        )


def test_what_is_no_data_frame_is_refused():
    for data in (None, {"total": [1]}, [[1]]):
        with pytest.raises(vrcomfort.InputError, match="should be a pandas data frame"):
            stats.mixed_model(data, dv="total", subject="who", factors="seen")


def test_anova_has_the_numbers_of_the_report(tidy):
    table = stats.rm_anova(tidy, dv="total", within="seen", between="group", subject="who")
    found = anova(tidy, value="total", participant="who", within=["seen"], between=["group"])
    assert table["effect"].tolist() == [each.effect for each in found.effects]
    for row, each in zip(table.to_dict("records"), found.effects, strict=True):
        assert (row["F"], row["p"], row["ges"]) == (each.f, each.p, each.generalised_eta_squared)
    within = table.set_index("effect").loc["seen"]
    assert within["eps_gg"] == found.effects[1].sphericity.greenhouse_geisser
    assert "seen" in stats.art_anova(tidy, dv="total", within="seen", subject="who")["effect"][0]


def test_published_numbers_of_t_tests_come_out_of_data_frames():
    """R's `sleep`: t = -4.0621, df = 9, p = .002833; exact Wilcoxon p = .003906."""
    one = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
    two = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
    sleep = pd.DataFrame({
        "id": [*range(10)] * 2, "drug": [1] * 10 + [2] * 10, "extra": one + two
    })  # fmt: skip
    row = stats.ttest(sleep, dv="extra", within="drug", subject="id").iloc[0]
    assert row["T"] == pytest.approx(-4.0621, abs=5e-5)
    assert (row["df"], row["p"]) == (9, pytest.approx(0.002833, abs=5e-7))
    assert row["BF10"] == pytest.approx(17.2589, abs=5e-5)
    ranks = stats.wilcoxon(sleep, dv="extra", within="drug", subject="id", zeros="wilcox")
    assert ranks["p"].item() == pytest.approx(0.003906, abs=5e-7)
    groups = stats.mwu(sleep, dv="extra", between="drug").iloc[0]
    assert (groups["n_A"], groups["n_B"], groups["U"]) == (10, 10, 25.5)


def test_models_tell_their_terms_and_their_fit(tidy):
    mixed = stats.mixed_model(
        tidy, dv="total", subject="who", factors="seen", references={"seen": "off"}
    )
    assert mixed["term"].tolist() == ["intercept", "seen: max − off", "seen: on − off"]
    assert mixed.attrs["n_participants"] == 12
    assert set(mixed.attrs["omnibus"]) == {"seen"}
    tidy["answer"] = (tidy["total"] // 15).astype(int)
    odds = stats.ordinal_model(tidy, dv="answer", subject="who", factors=["seen"])
    np.testing.assert_allclose(np.exp(odds["log_odds"]), odds["odds_ratio"])


def test_crossover_survival_and_agreement(tidy):
    two = tidy[tidy["seen"] != "max"].copy()
    first = two["who"].isin([f"P{n}" for n in range(1, 7)]) == (two["seen"] == "off")
    two["period"] = np.where(first, 1, 2)
    effects = stats.crossover(two, dv="total", within="seen", period="period", subject="who")
    means = two.pivot_table(index="who", columns="seen", values="total")
    assert effects["estimate"][0] == pytest.approx((means["off"] - means["on"]).mean())
    assert effects.attrs["n"] == {"off, on": 6, "on, off": 6}
    tidy["time"], tidy["ended"] = np.arange(36) + 10.0, tidy.index % 3 == 0
    curve = stats.kaplan_meier(tidy, time="time", event="ended", by="seen")
    assert curve.groupby("seen")["at_risk"].max().tolist() == [12, 12, 12]
    tested = stats.log_rank(tidy, time="time", event="ended", by="seen")
    assert tested["observed"].sum() == 12
    tidy["late"] = (tidy.index > 20).astype(int)
    tidy["ended"] = tidy.index % 4 == 0
    hazard = stats.cox(tidy, time="time", event="ended", covariates="total", subject="who")
    assert hazard["low"].item() < hazard["hazard_ratio"].item() < hazard["high"].item()
    forms = stats.icc(tidy, dv="total", within="seen", subject="who")
    assert forms["form"].tolist() == ["1,1", "2,1", "3,1", "1,k", "2,k", "3,k"]
    between = stats.corr(tidy, x="total", y="time", method="spearman")
    within = stats.corr(tidy, x="total", y="time", subject="who", method="repeated_measures")
    assert (between["n"].item(), within["n"].item()) == (36, 36)
    several = stats.kruskal(tidy, dv="total", between="seen")
    assert (several["groups"].item(), several["n"].item()) == (3, 36)


def test_views_are_arrays_and_show_themselves(tmp_path, monkeypatch):
    condition = vrcomfort.load_protocol("smoke").condition("both")
    pose = (-1, 1.6, -4.3, 47, -4, 0)
    views = vrcomfort.render_views(
        "temple", condition, pose=pose, previous_pose=(-1.03, 1.6, -4.3, 44, -4, 0),
        size_px=(32, 40), ipd_m=vrcomfort.load_protocol("smoke").headset.ipd_m,
    )  # fmt: skip
    assert views.left.rgb.shape == views.left.linear.shape == (40, 32, 3)
    assert views.left.distance_m.shape == (40, 32)
    assert 0.1 < views.left.distance_m.min() < 50
    assert views.left.arrays["velocity_px"].shape[:2] == (40, 32)
    shown = np.asarray(Image.open(io.BytesIO(views._repr_png_())))
    np.testing.assert_array_equal(shown, views.side_by_side)
    views.write(tmp_path / "api")
    words = ["--pose=-1,1.6,-4.3,47,-4,0", "--previous-pose=-1.03,1.6,-4.3,44,-4,0"]
    words += ["--protocol", "smoke", "--condition", "both", "--size", "32x40", "--quiet"]
    out = str(tmp_path / "command")
    monkeypatch.setattr(
        "sys.argv", ["vrcomfort", "render", "--scene", "temple", *words, "--out", out]
    )
    with pytest.raises(SystemExit):
        main()
    files = sorted(path.name for path in (tmp_path / "command").iterdir())
    assert files == sorted(path.name for path in (tmp_path / "api").iterdir())
    for name in files:
        assert (tmp_path / "api" / name).read_bytes() == (tmp_path / "command" / name).read_bytes()
    with pytest.raises(vrcomfort.InputError, match="is not a pose"):
        vrcomfort.render_views("temple", pose=(0, 1.6))


@pytest.mark.slow
def test_a_moment_of_a_trace_has_its_hands_and_what_moves(tmp_path):
    """Paddles that go with the head: false velocities under one condition of the study of hands."""
    walk = data_folder("scenes") / "depths_walk.csv"
    study = vrcomfort.load_protocol("motion_blur_2020_hands")
    speeds = {}
    for name in ("in_world", "with_head"):
        condition = study.condition(name)
        views = vrcomfort.render_views(
            "depths", condition, trace=walk, at_s=20.0, size_px=(96, 100)
        )
        speeds[name] = np.hypot(*np.moveaxis(views.left.arrays["velocity_px"], -1, 0))
        assert views.meta["time_s"] == 20.0
    held = (views.left.distance_m > 0.3) & (views.left.distance_m < 0.6)
    assert held.mean() > 0.01
    assert np.median(speeds["in_world"][held]) > 3 * np.median(speeds["with_head"][held])
    ball = (-3.4, 1.6, -2.7, 0, 0, 0)  # before the carousel, at 1.5 m
    at_rest, running = (
        vrcomfort.render_views("depths", condition, pose=ball, at_s=at_s, size_px=(96, 100))
        for at_s in (None, 3.0)
    )
    assert at_rest.left.arrays["velocity_px"].max() == 0
    assert np.abs(running.left.arrays["velocity_px"]).max() > 0.5
    running.write(tmp_path)
    picture = np.asarray(Image.open(tmp_path / "left_velocity.png"))
    moves = (running.left.arrays["velocity_px"] != 0).any(axis=-1)
    assert (picture[~moves] == 255).all()
    assert (picture[moves] != 255).any()
    for options, says in [
        ({"trace": walk, "pose": ball}, "a pose and a trace"),
        ({"trace": walk, "at_s": 1e4}, "nothing at 10000 s"),
        ({"at_s": -1.0}, "no time"),
        ({"trace": walk, "at_s": 20.0, "reference_samples": 2}, "nothing in hands"),
    ]:
        with pytest.raises(vrcomfort.InputError, match=says):
            vrcomfort.render_views("depths", condition, **options)


def test_the_page_has_every_public_name():
    page = (ROOT / "docs" / "python_api.md").read_text("utf-8").splitlines()
    names = [
        each for each in vrcomfort.__all__ if each not in {"__version__", "stats", "InputError"}
    ]
    names += [f"stats.{each}" for each in stats.__all__]
    assert [each for each in names if f"::: vrcomfort.{each}" not in page] == []


@pytest.mark.slow
@pytest.mark.filterwarnings("default::UserWarning")  # notes on the simulated data
def test_the_example_notebook_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    notebook = json.loads((ROOT / "examples" / "analysis_in_python.ipynb").read_text("utf-8"))
    assert notebook["nbformat"] == 4
    space, shown = {}, []
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            shown.append(_run("".join(cell["source"]), space))
    assert all(value is not None for value in shown[1:])
    assert any("dof" in str(value) for value in shown)
    assert (tmp_path / "report" / "index.html").exists()
    assert shown[-2]._repr_png_().startswith(b"\x89PNG")


def _run(source: str, space: dict[str, object]) -> object:
    """Run a cell as a notebook does; return the value of its last expression."""
    *before, last = ast.parse(source).body
    exec(compile(ast.Module(before, []), "cell", "exec"), space)  # noqa: S102
    if isinstance(last, ast.Expr):
        return eval(compile(ast.Expression(last.value), "cell", "eval"), space)  # noqa: S307
    exec(compile(ast.Module([last], []), "cell", "exec"), space)  # noqa: S102
    return None


def test_a_report_is_of_the_plan_that_was_read_whatever_its_file_says_now(tmp_path: Path) -> None:
    study = foreign(tmp_path / "questionnaires.csv", {f"P{i}": {"a": i, "b": 2} for i in range(7)})
    file = tmp_path / "mine.toml"
    file.write_text('name = "mine"\ntitle = "Mine"\noutcomes = ["T"]\nscores = "raw"\n', "utf-8")
    plan = vrcomfort.load_plan(file)
    file.write_text('name = "other"\ntitle = "Other"\n', "utf-8")
    with warnings.catch_warnings(record=True):  # of data without a baseline
        summary = vrcomfort.write_report(study, tmp_path / "out", plan=plan, forms=())
    assert summary.plan == "mine"
    assert (tmp_path / "out" / "plan.toml").read_text("utf-8") == plan.text


def test_a_plan_with_other_settings_than_its_text_is_refused(tmp_path: Path) -> None:
    study = foreign(tmp_path / "questionnaires.csv", {f"P{i}": {"a": i, "b": 2} for i in range(7)})
    changed = vrcomfort.load_plan("default").model_copy(update={"confidence": 0.9})
    with pytest.raises(vrcomfort.InputError, match="settings that are not in its text"):
        vrcomfort.write_report(study, tmp_path / "out", plan=changed, forms=())
    assert not (tmp_path / "out" / "index.html").exists()


def test_progress_counts_the_participants_that_are_simulated(tmp_path):
    told = []

    @contextmanager
    def progress(title, total, *, unit=""):
        told.append((title, total, unit))
        yield lambda: told.append(1)

    protocol = vrcomfort.load_protocol("smoke")
    more = {"size_px": (16, 16), "frames": False, "progress": progress}
    simulate_sessions(protocol, participants=2, out=tmp_path / "S", **more)
    assert told == [("simulated", 2, "participants"), 1, 1]
