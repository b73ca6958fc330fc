"""`vrcomfort tradeoff` as a user meets it, at 16×20 pixels."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest

from tests.support.cluster import local_cluster
from vrcomfort.cli import main
from vrcomfort.tradeoff import files, references
from vrcomfort.tradeoff.methods import methods
from vrcomfort.tradeoff.store import Store

SMALL = ("--size", "16x20", "--eyes", 2, "--samples", 8, "--views", 1, "--rounds", 1, "--jobs", 1)
ONE = (*SMALL, "--scene", "temple", "--effects", "depth_of_field", "--quick")
FEW = (*ONE, "--methods", "ours 36 samples")


@pytest.fixture
def run(monkeypatch, capsys):
    def call(*arguments):
        monkeypatch.setattr("sys.argv", ["vrcomfort", "tradeoff", *map(str, arguments)])
        code = 0
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capsys.readouterr()
        lines = err.splitlines(keepends=True)  # a busy machine's costs are doubted, and rightly
        return code, out, "".join(line for line in lines if "Do not believe" not in line)

    return call


def refused(result, *words):
    code, _, err = result
    assert code == 2
    assert err.count("\n") == 1, "one sentence, no traceback"
    assert all(word in err for word in words), err


def timeless(path):
    """Return the rows of a tradeoff.json without what a clock says."""
    found = json.loads(path.read_text())
    clocked = ("_ms", "cost", "_interval", "rounds")
    return [{k: v for k, v in row.items() if not k.endswith(clocked)} for row in found["rows"]]


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.mark.slow
def test_everything_is_written(run, tmp_path, cache):
    names = {method.name for method in methods("depth_of_field", quick=True)}
    names -= {"ours 16 views"}  # takes as long as all others
    chosen = ("--methods", ",".join(sorted(names)))
    code, out, err = run(*ONE, *chosen, "--cache", cache, "--out", tmp_path)
    assert (code, err) == (0, "")
    assert "index.html" in out
    with (tmp_path / "tradeoff.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["method"] for row in rows} == names | {"ideal scatter (R2)"}
    found = json.loads((tmp_path / "tradeoff.json").read_text())
    assert all(math.isfinite(row["rms"]) for row in found["rows"])
    assert all(row["effect_ms"] > 0 for row in found["rows"] if row["family"] == "ours")
    assert "llvmpipe" in found["device"] or found["timer"] == "time stamps of the GPU"
    for name in (
        "figures/temple_depth_of_field_lens3.5.svg",
        "figures/temple_depth_of_field_lens3.5.png",
    ):
        assert (tmp_path / name).stat().st_size > 1000
    page = (tmp_path / "index.html").read_text()
    assert all(name in page for name in names)
    decision, _, rest = page.partition('<details class="all">')
    assert rest.rstrip().endswith("</details>\n</body>\n</html>"), (
        "the decision stands before all else"
    )
    assert 'class="answer"' in decision
    assert decision.count("<svg") == 1
    assert decision.count("data:image/png") >= 3
    assert (tmp_path / "figures/choice_all_depth_of_field_lens3.5.png").stat().st_size > 1000
    assert "sheets/temple_depth_of_field_pose1_still_lens3.5.png" in page
    assert (tmp_path / "sheets/temple_depth_of_field_pose1_still_lens3.5.png").exists()


@pytest.mark.slow
def test_a_second_run_does_nothing_twice_and_says_so(run, tmp_path, cache):
    run(*FEW, "--cache", cache, "--out", tmp_path / "a")
    code, out, _ = run(*FEW, "--cache", cache, "--out", tmp_path / "b")
    assert code == 0
    assert "16 of 16 reference samples and 2 of 2 measurements" in out
    assert timeless(tmp_path / "a/tradeoff.json") == timeless(tmp_path / "b/tradeoff.json")


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on_to_the_same_numbers(run, tmp_path, monkeypatch):
    """Stopped in the third sample of the second eye."""
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    run(*FEW, "--cache", tmp_path / "c1", "--out", whole)
    drawn = []

    def stop(self, sums):
        drawn.append(sums.samples)
        if len(drawn) == 11:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(references._Keeper, "__call__", stop)
        code, _, _ = run(*FEW, "--cache", tmp_path / "c2", "--out", stopped)
    assert code == 130
    code, out, _ = run(*FEW, "--cache", tmp_path / "c2", "--out", stopped)
    assert code == 0
    assert out.startswith("11 of 16 reference samples and 0 of ")
    assert timeless(whole / "tradeoff.json") == timeless(stopped / "tradeoff.json")


@pytest.mark.slow
def test_what_a_run_finds_does_not_depend_on_the_runs_before_it(run, tmp_path):
    """Sixteen samples go on from the first eight; eight are eight where there are sixteen too."""

    def rows(name, samples, cache):
        folders = ("--cache", tmp_path / cache, "--out", tmp_path / name)
        code, out, _ = run(*FEW, "--samples", samples, *folders)
        assert code == 0
        return timeless(tmp_path / name / "tradeoff.json"), out

    few, _ = rows("few", 8, "c1")
    many, out = rows("many", 16, "c1")
    assert out.startswith("16 of 32 reference samples")
    assert many == rows("many_at_once", 16, "c2")[0]
    again, out = rows("few_again", 8, "c2")
    assert out.startswith("0 of 16 reference samples")
    assert again == few
    assert {row["samples"] for row in again} == {8}


@pytest.mark.slow
def test_a_reference_of_another_picture_is_drawn_again(run, tmp_path):
    folders = ("--cache", tmp_path / "c", "--out", tmp_path / "o", "--references")
    assert run(*FEW, *folders)[1].startswith("0 of 16 reference samples")
    assert run(*FEW, *folders)[1].startswith("16 of 16 reference samples")
    store = Store(tmp_path / "c")
    changed = store.keys("reference")[0]
    kept = store.read(changed)
    store.write(changed, **{**kept, "sharp": kept["sharp"] + np.float16(0.01)})
    assert run(*FEW, *folders)[1].startswith("8 of 16 reference samples")
    assert not (tmp_path / "o" / "index.html").exists()


@pytest.mark.slow
def test_one_eye_other_lenses_and_flicker(run, tmp_path, cache):
    """An eye has a case of its own; what one eye cannot know is blank, not zero."""
    chosen = (*FEW, "--eyes", 1, "--lens", "7,eye", "--flicker")
    code, _, err = run(*chosen, "--cache", cache, "--out", tmp_path)
    assert (code, err) == (0, "")
    rows = json.loads((tmp_path / "tradeoff.json").read_text())["rows"]
    assert {row["lens"] for row in rows} == {"7", "eye"}
    assert all(row["rivalry"] is None and row["flicker"] >= 0 for row in rows)
    blurred = [row for row in rows if row["method"] == "ours 36 samples"]
    assert all(row["reads_per_pixel"] > 1 and row["passes"] >= 2 for row in blurred)
    wide, narrow = (row["rms"] for row in rows if row["method"] == "no blur")
    assert wide > narrow, "an eye blurs less than 7 %"


@pytest.mark.slow
def test_pictures_of_an_earlier_run_do_not_stay_and_other_files_do(run, tmp_path, cache):
    for folder in ("figures", "sheets"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.png").touch()
    for chosen in ((*FEW, "--lens", 7), FEW):
        assert run(*chosen, "--cache", cache, "--out", tmp_path)[0] == 0
    there = {str(file.relative_to(tmp_path)) for file in tmp_path.glob("*/*")}
    assert there == {
        *("figures/mine.png", "sheets/mine.png"),
        *(f"figures/temple_depth_of_field_lens3.5.{kind}" for kind in ("svg", "png")),
        *(f"figures/choice_all_depth_of_field_lens3.5.{kind}" for kind in ("svg", "png")),
        "sheets/temple_depth_of_field_pose1_still_lens3.5.png",
    }


def test_earlier_numbers_that_cannot_be_read_remove_nothing(tmp_path):
    outside = tmp_path / "kept.svg"
    outside.touch()
    case = {"scene": "../../kept", "effect": "both", "pose": 0, "motion": "still"}
    out = tmp_path / "out"
    (out / "figures").mkdir(parents=True)
    strange = json.dumps({"rows": [{**case, "scene": "temple", "pose": "one"}]})
    for text in ("{", "[]", json.dumps({"rows": [case]}), json.dumps({"rows": [3]}), strange):
        (out / "tradeoff.json").write_text(text)
        files._remove_earlier(out)
    assert outside.exists()


@pytest.mark.slow
def test_processes_find_what_one_finds(run, tmp_path, cache):
    motion = (*SMALL, "--scene", "temple", "--effects", "motion_blur", "--quick")
    motion = (*motion, "--methods", "ours 8 samples")
    run(*motion, "--cache", tmp_path / "c1", "--out", tmp_path / "a")
    code, _, _ = run(*motion, "--jobs", 2, "--cache", tmp_path / "c2", "--out", tmp_path / "b")
    assert code == 0
    assert timeless(tmp_path / "a/tradeoff.json") == timeless(tmp_path / "b/tradeoff.json")


@pytest.mark.slow
def test_a_cluster_finds_what_one_process_finds(run, tmp_path, cache):
    run(*FEW, "--cache", cache, "--out", tmp_path / "a")
    with local_cluster(1) as address:
        folders = ("--cache", tmp_path / "c2", "--out", tmp_path / "b")
        code, _, err = run(*FEW, "--cluster", address, *folders)
    assert code == 0, err
    assert timeless(tmp_path / "a/tradeoff.json") == timeless(tmp_path / "b/tradeoff.json")


@pytest.mark.slow
def test_what_is_not_there_is_named(run, tmp_path):
    refused(run("--scene", "moon", "--out", tmp_path), "moon", "temple")
    refused(run("--lens", "9", "--out", tmp_path), "'9'", "3.5", "eye")
    refused(run("--windows", "--out", tmp_path), "1832x1920", "--size")
    refused(run("--effects", "glow", "--out", tmp_path), "glow", "motion_blur")
    refused(
        run("--methods", "magic", "--out", tmp_path),
        "'magic'", "depth_of_field has no blur", "motion_blur has no blur", "both has no blur",
    )  # fmt: skip
    lens_only = run("--methods", "mip", "--effects", "motion_blur", "--out", tmp_path)
    refused(lens_only, "motion_blur has no method 'mip'", "depth_of_field has")


@pytest.mark.slow
@pytest.mark.smoke
def test_a_method_needs_only_one_effect_that_has_it(run, tmp_path, cache):
    """Without --effects there is motion blur as well, which has no `ours 36 samples`."""
    chosen = ("--scene", "temple", "--quick", "--methods", "ours 36 samples")
    code, _, err = run(*SMALL, *chosen, "--cache", cache, "--out", tmp_path)
    assert (code, err) == (0, "")
    found = json.loads((tmp_path / "tradeoff.json").read_text())
    assert {row["effect"] for row in found["rows"]} == {"depth_of_field"}
    assert found["scope"]["effects"] == ["depth_of_field"]


def test_an_image_that_is_all_margin_is_refused(run, tmp_path):
    refused(run("--size", "1x1", "--out", tmp_path), "nothing can be compared", "--size")


def test_a_cache_that_cannot_be_written_is_refused(run, tmp_path):
    (tmp_path / "file").touch()
    refused(run(*ONE, "--cache", tmp_path / "file" / "x", "--out", tmp_path / "o"), "--cache")


def test_a_cluster_that_does_not_answer_is_refused(run, tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="distributed is not installed")
    monkeypatch.setattr("vrcomfort.workers.CONNECT_S", 1.0)
    result = run(
        *ONE, "--cluster", "tcp://127.0.0.1:9", "--cache", tmp_path, "--out", tmp_path / "o"
    )
    refused(result, "127.0.0.1:9", "dask scheduler")


def test_half_a_file_in_the_cache_is_nothing(tmp_path):
    store = Store(tmp_path)
    store.write("key", values=np.arange(3))
    np.testing.assert_array_equal(store.read("key")["values"], [0, 1, 2])
    file = tmp_path / "key.npz"
    file.write_bytes(file.read_bytes()[:40])
    assert store.read("key") is None
    assert store.read("other") is None
