"""The command line as a user meets it: answers, refusals in one sentence, exit codes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
import typer
from PIL import Image
from typer.main import get_command

from tests.support.places import ROOT
from vrcomfort.cli.app import COMMANDS, LazyCommands, app
from vrcomfort.gpu.gl import VERSION_NAME
from vrcomfort.resources import data_folder

README = ROOT / "README.md"
Run = Callable[..., tuple[int, str, str]]


def unity_log(folder: Path) -> Path:
    log = folder / "log.txt"
    log.write_text("Time x y z alpha beta gamma \n0.0,0,1.6,0,0,0,0\n0.1,0,1.6,0,0,0,0\n")
    return log


SSQ_ITEMS = (
    "general_discomfort,fatigue,headache,eyestrain,difficulty_focusing,increased_salivation,"
    "sweating,nausea,difficulty_concentrating,fullness_of_head,blurred_vision,dizzy_eyes_open,"
    "dizzy_eyes_closed,vertigo,stomach_awareness,burping"
)


def assert_refused(result: tuple[int, str, str], *words: str) -> None:
    code, _, err = result
    assert code == 2
    assert err.startswith("error: ")
    assert err.count("\n") == 1, "one sentence, no traceback"
    for word in words:
        assert word in err


@pytest.mark.parametrize(
    "command",
    [
        "run",
        "simulate",
        "play",
        "render",
        "report",
        "score",
        "design",
        "check",
        "schema",
        "passes",
        "import-trace",
        "import",
        "verify",
        "status",
        "anonymise",
        "export",
    ],
)
def test_every_command_has_help_with_an_example(run: Run, command: str) -> None:
    code, out, _ = run(command, "--help")
    assert code == 0
    assert f"vrcomfort {command}" in out


def test_run_declares_the_same_arguments_and_options_as_ever() -> None:
    """What people have typed in scripts goes on working; the help says the same of it."""
    commands = get_command(app)
    command = commands.get_command(typer.Context(commands), "run")
    lines = [command.help]
    for each in command.params:
        names = " ".join([*each.opts, *each.secondary_opts, each.metavar or ""]).strip()
        default = "required" if each.required else each.default
        lines.append(f"{names} [{default}]: {each.help}")
    golden = ROOT / "tests" / "golden" / "run_options.txt"
    assert "\n".join(lines) + "\n" == golden.read_text(encoding="utf-8")


def modules_after(*words: str) -> set[str]:
    """Return the modules that are loaded when the command line with these words has ended."""
    program = (
        "import sys; from vrcomfort.cli import main; sys.argv = ['vrcomfort', *sys.argv[1:]]\n"
        "try: main()\nexcept SystemExit: pass\n"
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *words], check=True, capture_output=True, text=True
    )
    return set(done.stdout.splitlines()[-1].split())


@pytest.mark.parametrize("words", [(), ("--version",), ("--help",), ("reprot",)])
def test_the_command_line_starts_with_no_commands_module(words: tuple[str, ...]) -> None:
    loaded = modules_after(*words)
    assert {each for each in loaded if each.partition(".")[0] == "vrcomfort"} == {
        "vrcomfort",
        "vrcomfort.cli",
        "vrcomfort.cli.app",
        "vrcomfort.cli.stopping",
        "vrcomfort.cli.terminal",
        "vrcomfort.errors",
        "vrcomfort.escaping",
        "vrcomfort.stop_signals",
    }
    heavy = {"numpy", "pandas", "scipy", "PIL", "moderngl", "matplotlib", "duckdb"}
    if words != ("reprot",):
        heavy.add("pydantic")  # by which Typer reads words that are no options
    if words == ("--version",):
        heavy.add("rich.markdown")
    assert not loaded & heavy


def test_a_command_imports_no_other_commands_module() -> None:
    modules = {f"vrcomfort.cli.{each.module}" for each in COMMANDS.values()}
    assert modules_after("score", "--help") & modules == {"vrcomfort.cli.report"}
    assert modules_after("note", "--help") & modules == {"vrcomfort.cli.participants"}


def test_the_help_says_of_each_command_what_the_command_itself_does() -> None:
    group = get_command(app)
    assert isinstance(group, LazyCommands)
    for name, listed in COMMANDS.items():
        command = group.get_command(None, name)
        assert command.help.split("\n\n")[0] == listed.help, name
        assert command.hidden == listed.hidden, name


def test_a_misspelt_command_is_compared_with_all(run: Run) -> None:
    code, _, err = run("reprot")
    assert code == 2
    assert err == (
        "error: no such command 'reprot'; did you mean 'report', 'export'? See vrcomfort --help\n"
    )


@pytest.mark.smoke
def test_design_of_carnegie_is_balanced_for_twenty(run: Run) -> None:
    code, out, _ = run("design", "carnegie_2015", "--participants", 20, "--json")
    design = json.loads(out)
    assert code == 0
    assert design["conditions"]["first"] == {"dof_off": 10, "dof_on": 10}
    assert set(design["crossing"].values()) == {5}
    assert len(design["crossing"]) == 4
    assert "divide evenly" in design["remainder"]


def test_design_says_what_it_does_when_the_number_does_not_divide(run: Run) -> None:
    _, out, _ = run("design", "carnegie_2015", "-n", 22)
    words = " ".join(out.split())
    assert "22 participants do not divide by 4 sequences" in words
    assert "goes back to the pool" in words


@pytest.mark.slow
def test_passes_leaves_out_the_effects_that_a_condition_does_not_have(run: Run) -> None:
    _, out, _ = run("passes", "carnegie_2015", "--size", "64x48", "--json")
    needed = {
        (row["scene"], row["condition"], row["name"]): row["needed"]
        for row in json.loads(out)["passes"]
    }
    assert needed["temple", "dof_on", "depth_of_field"]
    assert not needed["temple", "dof_off", "depth_of_field"]
    assert not needed["temple", "dof_off", "focus"]
    assert not needed["mountain", "dof_on", "velocity"]


@pytest.mark.slow
def test_passes_says_what_conditions_cost_and_what_has_not_been_measured(
    run: Run, tmp_path: Path
) -> None:
    from vrcomfort.protocol.quality_levels import quality_table

    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    lens = "[conditions.depth_of_field]"
    file.write_text(text.replace(lens, f"{lens}\nsamples = 70", 1), encoding="utf-8")
    code, out, _ = run("passes", file, "--size", "64x48", "--json")
    answer = json.loads(out)
    costs = {row["condition"]: row for row in answer["costs"]}
    assert code == 0
    assert (costs["plain"]["cost_ratio"], costs["plain"]["flip"]) == (1.0, None)
    assert costs["dof"]["quality"] == "own settings"
    assert (costs["dof"]["cost_ratio"], costs["dof"]["psnr_db"]) == (None, None)
    shipped = {(row.level, row.effects, row.scene): row for row in quality_table().figures}
    for name, effects in (("motion", "motion_blur"), ("both", "both")):
        figure = shipped.get(("balanced", effects, "temple"))
        assert costs[name]["cost_ratio"] == (figure and figure.cost_ratio)
    assert costs["motion"]["cost_ratio"] > 1
    assert answer["measured"]["device"]
    memory = {name: row["gpu_megabytes"]["total"] for name, row in costs.items()}
    assert memory["both"] > memory["motion"] > memory["plain"] > 0
    _, small, _ = run("passes", file, "--size", "32x48", "--json")
    halved = json.loads(small)["costs"][0]["gpu_megabytes"]
    # Half as wide: of the targets all but the shadow map shrinks, of the scene nothing.
    assert halved["image"] == costs["plain"]["gpu_megabytes"]["image"]
    assert halved["target"] < costs["plain"]["gpu_megabytes"]["target"]


def test_passes_is_readable_and_needs_no_opengl(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from vrcomfort.errors import InputError
    from vrcomfort.gpu import gl

    def fail() -> None:
        raise InputError("no OpenGL 4.5 context could be made")

    monkeypatch.setattr(gl, "create_context", fail)
    monkeypatch.setenv("COLUMNS", "100")
    code, out, _ = run("passes", "carnegie_2015")
    words = " ".join(out.split())
    assert code == 0
    assert max(map(len, out.splitlines())) <= 100
    assert "GPU memory is not known: no OpenGL 4.5 context could be made" in words
    assert "nothing is out of focus without depth of field" in words


@pytest.mark.slow
def test_the_old_name_of_passes_still_works_and_tells_the_new_one(run: Run) -> None:
    asked = ("smoke", "--size", "16x16", "--no-draw", "--json")
    _, now, silent = run("passes", *asked)
    code, before, told = run("plan", *asked)
    assert (code, before, silent) == (0, now, "")
    assert told.startswith("note: ")
    assert told.count("\n") == 1
    assert "vrcomfort passes" in told
    _, help_text, _ = run("--help")
    assert not any(line.split()[1:2] == ["plan"] for line in help_text.splitlines())
    assert any(line.split()[1:2] == ["passes"] for line in help_text.splitlines())


@pytest.mark.slow
def test_passes_says_where_a_level_would_change_the_stimulus(run: Run, tmp_path: Path) -> None:
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    text = text.replace('name = "dof"\n', 'name = "dof"\nquality = "accurate"\n', 1)
    fixed = '[conditions.focus]\nmethod = "fixed"\nfixed_m = 0.4'
    text = text.replace('[conditions.focus]\nlaw = "linear_dioptre"\nmean = "dioptres"', fixed, 1)
    file.write_text(text, encoding="utf-8")
    _, out, _ = run("passes", file, "--size", "64x48", "--json")
    (told,) = json.loads(out)["no_limit"]
    assert (told["condition"], told["views"], told["limit_dioptre"]) == ("dof", 16, 2.0)
    (only,) = told["ranges"]
    assert only == {
        "focus_m": 0.4,
        "nearer_than_m": pytest.approx(1 / 4.5),
        "farther_than_m": pytest.approx(2.0),
    }
    _, words, _ = run("passes", file, "--size", "64x48")
    assert "focused at 0.4 m, nearer than 0.22 m or farther than 2 m" in " ".join(words.split())
    _, out, _ = run("passes", "smoke", "--size", "64x48", "--json")
    assert json.loads(out)["no_limit"] == []


@pytest.mark.smoke
def test_score_gives_a_table_that_reads_back(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "answers.csv"
    file.write_text(f"who,{SSQ_ITEMS}\nA,{','.join('3' * 16)}\n", encoding="utf-8")
    code, out, _ = run("score", "ssq", file, "--json")
    (row,) = json.loads(out)
    assert code == 0
    assert (row["who"], row["total"], row["total_raw"]) == ("A", pytest.approx(235.62), 63)


def test_score_writes_as_many_decimals_as_a_score_has(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "answers.csv"
    items = ["2", *["0"] * 4, *["3"] * 2, "2", *["0"] * 6, "1", "1"]  # twelve points of nausea
    file.write_text(f"who,{SSQ_ITEMS}\nA,{','.join(items)}\n", encoding="utf-8")
    assert run("score", "ssq", file)[1].splitlines() == [
        "who,nausea_raw,oculomotor_raw,disorientation_raw,total_raw,"
        "nausea,oculomotor,disorientation,total",
        "A,12,2,2,16,114.48,15.16,27.84,59.84",
    ]


@pytest.mark.parametrize("long", [False, True])
def test_score_leaves_incomplete_rows_out_where_asked(run: Run, tmp_path: Path, long: bool) -> None:
    file = tmp_path / "answers.csv"
    names = SSQ_ITEMS.split(",")
    if long:
        rows = [f"P1,{name},1" for name in names] + [f"P2,{name},1" for name in names[1:]]
        file.write_text("participant,item,response\n" + "\n".join(rows) + "\n")
    else:
        answers = ",".join(["1"] * 15)
        file.write_text(f"participant,{SSQ_ITEMS}\nP1,1,{answers}\nP2,,{answers}\n")
        assert_refused(run("score", "ssq", file), "line 3", "--skip-incomplete")
    code, out, err = run("score", "ssq", file, "--skip-incomplete")
    assert code == 0
    assert [line.split(",")[0] for line in out.splitlines()] == ["participant", "P1"]
    line = 18 if long else 3
    assert (
        f"1 of 2 questionnaires lack answers and were left out; they begin in line: {line}" in err
    )


def test_readme_doctor_and_driver_mean_the_same_opengl(run: Run) -> None:
    assert VERSION_NAME == "4.5"
    assert f"OpenGL {VERSION_NAME} is needed" in README.read_text(encoding="utf-8")
    _, out, _ = run("doctor", "--json")
    (opengl,) = (each for each in json.loads(out) if each["part"] == "OpenGL")
    assert opengl["found"].endswith(f"needed: {VERSION_NAME}")


def test_score_names_the_place_of_an_answer_out_of_range(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "answers.csv"
    file.write_text(f"who,{SSQ_ITEMS}\nA,4,{','.join('0' * 15)}\n", encoding="utf-8")
    assert_refused(run("score", "ssq", file), "line 2", "general_discomfort", "4")


def test_unknown_questionnaire_is_refused(run: Run, tmp_path: Path) -> None:
    assert_refused(run("score", "vas", tmp_path / "x.csv"), "ssq")


def test_unknown_protocol_is_refused_with_those_there_are(run: Run) -> None:
    assert_refused(run("design", "carnegie_2016"), "carnegie_2016", "carnegie_2015")


def test_misspelt_protocol_key_is_refused_with_its_place(run: Run, tmp_path: Path) -> None:
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(text.replace("exposure_s", "exposure_ms", 1), encoding="utf-8")
    line = next(i for i, row in enumerate(text.splitlines(), 1) if row.startswith("exposure_s"))
    assert_refused(run("passes", file), "mine.toml", f"line {line}", "exposure_s")


@pytest.mark.parametrize("size", ["640", "0x400", "axb", "²x³", "99999x10"])
def test_bad_sizes_are_refused(run: Run, tmp_path: Path, size: str) -> None:
    assert_refused(run("render", "--scene", "temple", "--size", size, "--out", tmp_path), "--size")


@pytest.mark.parametrize("pose", ["1,2,3", "a,b,c,d,e,f", "0,0,0,0,0,nan"])
def test_bad_poses_are_refused(run: Run, tmp_path: Path, pose: str) -> None:
    result = run("render", "--scene", "temple", "--pose", pose, "--out", tmp_path)
    assert_refused(result, "--pose", "X,Y,Z,YAW,PITCH,ROLL")


def test_poses_far_from_everything_are_refused(run: Run, tmp_path: Path) -> None:
    result = run("render", "--scene", "temple", "--pose", "1e300,0,0,0,0,0", "--out", tmp_path)
    assert_refused(result, "--pose", "1000 km")


def test_condition_without_protocol_is_refused(run: Run, tmp_path: Path) -> None:
    result = run("render", "--scene", "temple", "--condition", "dof_on", "--out", tmp_path)
    assert_refused(result, "--protocol")


def test_condition_that_the_protocol_lacks_is_refused(run: Run, tmp_path: Path) -> None:
    options = ("--protocol", "carnegie_2015", "--condition", "blurry")
    result = run("render", "--scene", "temple", *options, "--out", tmp_path)
    assert_refused(result, "blurry", "dof_on")


def test_a_folder_name_too_long_for_a_disk_is_refused(run: Run, tmp_path: Path) -> None:
    options = ("--participant", "P01", "--respondent", "simulated", "--out", tmp_path / ("S" * 300))
    assert_refused(run("run", "smoke", *options), "too long", "shorter")


def test_results_are_never_written_into_a_study_folder(run: Run, tmp_path: Path) -> None:
    (tmp_path / "participants.csv").write_text("participant\n", encoding="utf-8")
    assert_refused(run("render", "--scene", "temple", "--out", tmp_path), "study folder")


def test_results_never_replace_a_recording(run: Run, tmp_path: Path) -> None:
    for name in ("manifest.json", "frames.csv"):
        (tmp_path / name).write_text("recorded", encoding="utf-8")
    log = unity_log(tmp_path)
    assert_refused(run("render", "--scene", "temple", "--out", tmp_path), "a session")
    assert_refused(run("import-trace", log, "--out", tmp_path / "frames.csv"), "a session")
    assert (tmp_path / "frames.csv").read_text("utf-8") == "recorded"


def test_a_link_to_a_recording_is_not_written_through(run: Run, tmp_path: Path) -> None:
    study = tmp_path / "ses-1"
    study.mkdir()
    for name in ("manifest.json", "frames.csv"):
        (study / name).write_text("recorded", encoding="utf-8")
    log, link = unity_log(tmp_path), tmp_path / "trace.csv"
    link.symlink_to(study / "frames.csv")
    assert_refused(run("import-trace", log, "--out", link), "a session")
    assert (study / "frames.csv").read_text("utf-8") == "recorded"


def test_a_log_is_not_replaced_by_what_is_made_of_it(run: Run, tmp_path: Path) -> None:
    log = unity_log(tmp_path)
    before = log.read_bytes()
    (tmp_path / "soft.txt").symlink_to(log)
    (tmp_path / "hard.txt").hardlink_to(log)
    for out in (log, tmp_path / "soft.txt", tmp_path / "hard.txt", tmp_path / "." / "log.txt"):
        made = run("import-trace", log, "--out", out)
        assert_refused(made, out.name, "choose another output folder")
        assert log.read_bytes() == before


def test_a_trace_is_not_replaced_by_its_playback(run: Run, tmp_path: Path) -> None:
    played = tmp_path / "played"
    played.mkdir()
    assert run("import-trace", unity_log(tmp_path), "--out", played / "frames.csv")[0] == 0
    before = (played / "frames.csv").read_bytes()
    options = ("--scene", "temple", "--out", played)
    made = run("play", played / "frames.csv", *options)
    assert_refused(made, "frames.csv", "another output folder")
    assert (played / "frames.csv").read_bytes() == before


def test_a_trace_is_played_under_two_conditions(run: Run, tmp_path: Path) -> None:
    """The left eye's image of each: alone, each gives the same."""
    walk = data_folder("scenes") / "depths_walk.csv"
    study = ("--scene", "depths", "--protocol", "motion_blur_2020_hands", "--frames", "2")
    pictures = {}
    for name, condition, beside in (
        ("both", "in_world", ("--beside", "with_head")),
        ("first", "in_world", ()),
        ("second", "with_head", ()),
    ):
        shown = ("--condition", condition, *beside, "--size", "64x70", "--out", tmp_path / name)
        code, _, err = run("play", walk, *study, *shown)
        assert code == 0, err
        picture = np.asarray(Image.open(tmp_path / name / "frames" / "000001.png"))
        pictures[name] = picture[:, :64], picture[:, 64:]
    np.testing.assert_array_equal(pictures["both"][0], pictures["first"][0])
    np.testing.assert_array_equal(pictures["both"][1], pictures["second"][0])


@pytest.mark.slow
def test_answers_are_not_replaced_by_their_report(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "tables" / "descriptives.csv"
    file.parent.mkdir()
    rows = ["participant,timepoint,condition,item,response"]
    rows += [
        f"P{person},post,{condition},{item},{(person + n) % 4}"
        for person in range(5)
        for condition in ("on", "off")
        for n, item in enumerate(SSQ_ITEMS.split(","))
    ]
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")
    before = file.read_bytes()
    options = ("--figures", "none", "--out", tmp_path)
    assert_refused(run("report", file, *options), "descriptives.csv", "another output folder")
    assert file.read_bytes() == before
    assert not (tmp_path / "index.html").exists()


def test_trace_that_is_none_is_refused(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "trace.csv"
    file.write_text("time,x\n0,1\n", encoding="utf-8")
    assert_refused(run("play", file, "--scene", "temple", "--out", tmp_path / "o"), "xr_time_ns")


@pytest.mark.parametrize("command", ["play", "render"])
def test_a_scene_is_looked_for_where_the_user_stands(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    assert run("import-trace", unity_log(tmp_path), "--out", tmp_path / "walk.csv")[0] == 0
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    trimesh.Scene([trimesh.creation.box()]).export(here / "box.glb")
    trace = ("../walk.csv", "--frames", "1") if command == "play" else ()
    shown = ("--protocol", "carnegie_2015", "--condition", "dof_on", "--size", "32x40")
    assert run(command, *trace, "--scene", "box.glb", *shown, "--out", "made")[0] == 0
    assert json.loads((here / "made" / "meta.json").read_text())["scene"] == "box"


def test_broken_scene_is_refused(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "broken.glb"
    file.write_bytes(b"glTF\x02\x00\x00\x00 and then nothing")
    assert_refused(run("render", "--scene", file, "--out", tmp_path / "o"), "broken.glb")


def test_unity_log_becomes_a_trace(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    rows = ["Time x y z alpha beta gamma ", "0.00,0,1.6,0,0,0,0", "0.01,0,1.6,0.02,0,0,0"]
    log.write_text("\n".join(rows) + "\n", encoding="utf-8")
    trace = tmp_path / "trace.csv"
    code, _, _ = run("import-trace", log, "--format", "unity-euler", "--out", trace)
    header, _, last = trace.read_text(encoding="utf-8").splitlines()
    assert code == 0
    # Unity's +z is forward; ours is backward.
    assert dict(zip(header.split(","), last.split(","), strict=True))["head_z_m"] == "-0.02"


def test_help_says_what_a_unity_log_looks_like(run: Run) -> None:
    said = " ".join(run("import-trace", "--help")[1].split())
    for words in (
        *("Time x y z alpha beta gamma", "seconds", "metres"),
        *("left-handed", "z forward", "degrees", "z first, then x, then y"),
    ):
        assert words in said


def test_doctor_finds_what_the_tests_need(run: Run) -> None:
    code, out, _ = run("doctor", "--json")
    assert code == 0
    assert {finding["part"] for finding in json.loads(out)} >= {"OpenGL", "Python", "scenes"}


def test_a_protocol_that_is_no_text_is_refused(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_bytes('name = "mine"\ntitle = "Café"\n'.encode("latin-1"))
    assert_refused(run("design", file), "mine.toml, line 2: this line is not UTF-8", "save")
    assert_refused(run("design", tmp_path), "is a folder", "TOML")


def test_answers_that_are_no_text_are_refused(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    script = tmp_path / "answers.txt"
    script.write_bytes(b"1 2\n\xe9\n")
    trace = data_folder("scenes") / "temple_walk.csv"
    rehearsal = ("--headset", "openxr", "--monado-trace", trace, "--monado-answers", script)
    result = run("run", "smoke", "--participant", "P01", *rehearsal, "--out", tmp_path / "S")
    assert_refused(result, "answers.txt, line 2: this line is not UTF-8")


def test_a_folder_that_takes_no_files_is_refused_before_the_work(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Nothing is forbidden to root, who may be running this.
    monkeypatch.setattr(os, "access", lambda _, mode: mode != os.W_OK)
    commands = [("tradeoff", "--quick"), ("demo",), ("render", "--scene", "temple")]
    for command in commands:
        assert_refused(run(*command, "--out", tmp_path), "cannot be written to; choose another")


@pytest.mark.slow
def test_ctrl_c_in_a_session_ends_the_demo(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vrcomfort.headset.playback.PlaybackHeadset.frames", stop)
    code, out, err = run("demo", "--out", tmp_path, "-n", 2)
    assert (code, err) == (130, "error: stopped; what was already written stays\n")
    assert out.count("\n") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"study"}
