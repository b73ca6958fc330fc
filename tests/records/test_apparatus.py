"""Sessions of one study that differ in size, rate, software or GPU are named, by one rule."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from typer.testing import CliRunner

from tests.support.report import build_report
from vrcomfort.api.playback import PlaybackSetup
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.exchange.status import status_of
from vrcomfort.frame import STIMULUS_VERSION
from vrcomfort.protocol import load_protocol
from vrcomfort.records.apparatus import differences, differences_in, require_stimulus

PLAIN = """
name = "plain"
title = "Two conditions that need no pass of their own"
exposure_s = 0.2
break_s = 0.0
scenes = ["temple"]
conditions = [{ name = "a" }, { name = "b" }]
order = { rule = "williams" }
questionnaires = [
  { timepoint = "baseline", when = "session_start" },
  { timepoint = "post", when = "after_trial" },
]
"""
FIRST = {
    "participant": "P01",
    "session": 1,
    "headset": {"name": "playback", "image_size_px": [640, 800], "refresh_hz": 89.98},
    "runtime": "SteamVR 2.5",
    "gpu": "A",
    "driver": "1",
    "versions": {"vrcomfort": "0.2.0"},
}


def of(participant: str, **changed: object) -> dict[str, object]:
    return FIRST | {"participant": participant} | changed


def test_sessions_that_are_alike_have_no_sentence() -> None:
    rate = {**FIRST["headset"], "refresh_hz": 90.01}  # type: ignore[dict-item]
    assert differences([FIRST, of("P02"), of("P03", headset=rate)]) == []
    unknown = {**FIRST["headset"], "refresh_hz": 0.0}  # type: ignore[dict-item]
    assert differences([FIRST, of("P02", headset=unknown, driver="", versions={})]) == []


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"gpu": "B"}, "sessions differ in the GPU: A in P01/ses-1; B in P02/ses-1"),
        ({"runtime": "X"}, "sessions differ in the runtime: SteamVR 2.5 in P01/ses-1; X in P02"),
        ({"driver": "2"}, "sessions differ in the graphics driver: 1 in P01/ses-1; 2 in P02/ses-1"),
        (
            {"versions": {"vrcomfort": "0.3.0"}},
            "sessions differ in the version of vrcomfort: 0.2.0 in P01/ses-1; 0.3.0 in P02/ses-1",
        ),
    ],
)
def test_each_fact_that_differs_is_a_sentence(changed: dict[str, object], sentence: str) -> None:
    (found,) = differences([FIRST, of("P02", **changed)])
    assert found.startswith(sentence)


Run = Callable[..., Result]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a protocol and a study of one participant."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "plain.toml").write_text(PLAIN, "utf-8")
    assert "sessions differ" not in run_in(folder)("P01", "32x40", "10").stderr
    return folder


def run_in(folder: Path) -> Run:
    def run(participant: str, size: str, rate: str, *more: str) -> Result:
        words = ["run", str(folder / "plain.toml"), "--participant", participant, "-q", *more]
        words += ["--out", str(folder / "S"), "--respondent", "simulated"]
        words += ["--size", size, "--refresh-hz", rate]
        done = CliRunner().invoke(app, words, catch_exceptions=False)
        assert done.exit_code == 0, done.output
        return done

    return run


def test_what_differs_is_named_by_run_status_and_report(tmp_path: Path, recorded: Path) -> None:
    """Another stimulus has to be asked for besides."""
    run, study = run_in(shutil.copytree(recorded, tmp_path, dirs_exist_ok=True)), tmp_path / "S"
    file = study / "sub-P01" / "ses-1" / "manifest.json"
    manifest = json.loads(file.read_text("utf-8"))
    assert manifest["stimulus_version"] == STIMULUS_VERSION
    file.write_text(json.dumps({**manifest, "stimulus_version": 99}), "utf-8")
    with pytest.raises(InputError, match="P01/ses-1 was shown version 99 of the stimulus"):
        run("P02", "40x48", "20")
    assert not (study / "sub-P02").exists()
    told = " ".join(run("P02", "40x48", "20", "--other-stimulus").stderr.split())
    second = json.loads((study / "sub-P02/ses-1/manifest.json").read_text("utf-8"))
    assert second["stimulus_version"] == STIMULUS_VERSION
    expected = [
        f"sessions differ in {fact} in P01/ses-1; {other} in P02/ses-1"
        for fact, other in (
            ("the image size of an eye: 32×40", "40×48"),
            ("the refresh rate: 10 Hz", "20 Hz"),
            ("the version of the stimulus: 99", f"{STIMULUS_VERSION}"),
        )
    ]
    assert [told.count(each) for each in expected] == [1, 1, 1]
    assert sorted(status_of(study).differences) == sorted(differences_in(study)) == sorted(expected)
    shown = " ".join(CliRunner().invoke(app, ["status", str(study)]).stderr.split())
    assert expected[0] in shown
    summary = build_report(study, out=tmp_path / "report")
    page = summary.index.read_text("utf-8")
    assert set(expected) <= set(summary.warnings)
    assert all(each[1:] in page for each in expected)  # there with a capital letter


def test_a_study_without_sessions_or_versions_goes_on(tmp_path: Path) -> None:
    require_stimulus(tmp_path, STIMULUS_VERSION)
    require_stimulus(tmp_path / "none", STIMULUS_VERSION)


def test_a_session_that_went_on_elsewhere_is_named_with_both() -> None:
    earlier = {key: value for key, value in of("P01", gpu="B").items() if key != "participant"}
    (found,) = differences([FIRST | {"earlier_runs": [earlier]}])
    assert found == "sessions differ in the GPU: B in P01/ses-1; A in P01/ses-1"


def test_many_sessions_are_counted() -> None:
    (found,) = differences([FIRST, *(of(f"P{n:02d}", gpu="B") for n in range(2, 9))])
    assert found.endswith("B in P02/ses-1, P03/ses-1, P04/ses-1, P05/ses-1 and 3 more")


def test_a_protocol_that_begins_with_a_view_has_a_headset_at_its_start() -> None:
    protocol = load_protocol("mantiuk_2011")
    assert protocol.scenes[0] in [view.name for view in protocol.views]
    headset = PlaybackSetup((32, 40), 0.063).at_start(protocol)
    assert headset.image_size_px == (32, 40)
