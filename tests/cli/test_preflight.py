"""`preflight`: what stands in the way before people come, and when `run` asks for it again."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import moderngl
import pytest

from tests.support.places import ROOT
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.api.timed_show import COST_ROUNDS, Cost, TimedShow, costs
from vrcomfort.cli.preflight_checks import CHECKS, FRAME_BYTES, Preflight
from vrcomfort.cli.run import DESKTOP, OPENXR, PLAYBACK, RunOptions, _preflight
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.gpu.adapters import adapters, faster_adapters
from vrcomfort.protocol import load_protocol
from vrcomfort.records.disk import OWNER
from vrcomfort.records.json_file import PreflightShape
from vrcomfort.records.preflights import FILE, read_preflight, why_again, write_preflight
from vrcomfort.render.pipeline import StereoRenderer, looks_around
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.session.frame_log import TrialTiming

Run = Callable[..., tuple[int, str, str]]
FIND = {check.name: check.find for check in CHECKS}
QUICK = ("--headset", "playback", "--size", "32x40", "--seconds", "0.1")
FACTS = {"headset": {"image_size_px": [64, 80], "refresh_hz": 90.0}, "gpu": "A"}
DONE = {
    "at": datetime.now(UTC).isoformat(timespec="seconds"),
    "outcome": "ok",
    "protocol": {"name": "smoke", "sha256": "1"},
    "headset": "openxr",
    "apparatus": {"image size of an eye": "64×80", "refresh rate": "90 Hz", "GPU": "A"},
    "findings": [],
}


def flight(headset: Any = OPENXR, name: str = "smoke", **facts: Any) -> Preflight:
    run = RunOptions(protocol=name, participant="P", out=Path("nowhere"), headset=headset)
    return Preflight(run, load_protocol(name), facts=facts)


def outcomes(name: str, about: Preflight) -> list[str]:
    return [finding.outcome for finding in FIND[name](about)]


@pytest.mark.slow
def test_what_is_found_is_shown_and_written(run: Run, tmp_path: Path) -> None:
    code, out, err = run("preflight", "smoke", "--out", tmp_path / "S", *QUICK)
    assert code == 0, err
    content = json.loads((tmp_path / "S" / FILE).read_text())
    assert read_preflight(tmp_path / "S") is not None
    parts = [each["part"] for each in content["findings"]]
    assert {"wording", "OpenGL", "GPU", "disk", "clock", "rate holds", "IPD", "stop"} <= set(parts)
    assert all(part in out for part in parts)
    costs = content["costs_ms"]
    assert len(costs) == 4
    assert max(costs, key=costs.get) == "{condition} in {scene}".format(**content["timing"])
    assert content["timing"]["frames"] == pytest.approx(0.1 * 72, abs=2)
    assert content["apparatus"]["image size of an eye"] == "32×40"
    assert content["outcome"] in {"ok", "notice"}


@pytest.mark.parametrize(
    ("busy_ms", "outcome"), [(None, "ok"), (5.0, "ok"), (9.0, "notice"), (12.0, "notice")]
)
def test_a_rate_that_is_just_held_is_told(busy_ms: float | None, outcome: str) -> None:
    timing = TrialTiming(frames=9)
    if busy_ms is not None:
        timing.cpu.add(busy_ms)
    show = TimedShow(Cost("temple", "both", 3.0), timing, period_ms=10.0)
    about = replace(flight(), shown=show)
    assert outcomes("rate holds", about) == [outcome]


@pytest.mark.parametrize(("free", "outcome"), [(1, "refuse"), (3, "notice"), (5, "ok")])
def test_the_disk_has_room_for_a_session_and_for_the_study(
    monkeypatch: pytest.MonkeyPatch, free: int, outcome: str
) -> None:
    """Of four participants with a session of four exposures each."""
    about = flight()
    session_bytes = 4 * 0.1 * about.protocol.headset.refresh_hz * FRAME_BYTES
    usage = SimpleNamespace(free=free * session_bytes)
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage)
    (found,) = FIND["disk"](about)
    assert (found.part, found.outcome) == ("disk", outcome)
    assert ("the study's 4 participants need about" in found.remedy) == (outcome == "notice")


def test_what_conditions_cost_is_measured_in_frames_that_are_drawn(
    ctx: moderngl.Context, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    smoke = (data_folder("protocols") / "smoke.toml").read_text("utf-8")
    (tmp_path / "small.toml").write_text(smoke.replace('"temple"', '"depths"'), "utf-8")
    drawn = []
    render = StereoRenderer.render

    def counted(renderer: StereoRenderer, *given: Any) -> Any:
        drawn.append(given[0])
        return render(renderer, *given)

    monkeypatch.setattr(StereoRenderer, "render", counted)
    protocol = load_protocol(tmp_path / "small.toml")
    found = costs(protocol, StereoRenderer(ctx, (8, 10)), load_scene)
    assert [each.scene for each in found] == 4 * ["depths"]
    assert len(drawn) == 4 * COST_ROUNDS * len(looks_around(Pose()))


def test_codes_for_words_stand_in_the_way(run: Run, tmp_path: Path) -> None:
    text = PROTOCOL.replace('timepoint = "recovery"', 'timepoint = "recovery"\ninstrument = "ipq"')
    file, study = tiny_protocol(tmp_path, text).file, tmp_path / "S"
    code, out, _ = run("preflight", file, "--out", study, "--headset", "openxr", "--json")
    assert code == 2
    found = json.loads(out)
    wording = next(each for each in found["findings"] if each["part"] == "wording")
    assert wording["outcome"] == found["outcome"] == "refuse"
    assert "the IPQ has no wording in `en` for ipq_g1" in wording["remedy"]
    assert json.loads((study / FILE).read_text())["outcome"] == "refuse"


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({}, ""),
        ({"at": (datetime.now(UTC) - timedelta(days=1)).isoformat()}, "and not today"),
        ({"protocol": {"name": "smoke", "sha256": "2"}}, "the protocol has changed"),
        ({"headset": "playback"}, "was with --headset playback"),
        ({"apparatus": {"GPU": "B"}}, "the GPU was B in the last preflight, and is A now"),
        ({"apparatus": {"refresh rate": "72 Hz"}}, "the refresh rate was 72 Hz"),
        ({"rehearsed": True}, "was a rehearsal"),
        ({"outcome": "refuse"}, "what stands in the way"),
    ],
)
def test_a_session_asks_for_what_no_longer_holds(changed: dict[str, Any], words: str) -> None:
    done = PreflightShape.model_validate({**DONE, **changed})
    why = why_again(done, protocol_sha256="1", headset="openxr", run=FACTS)
    assert (words in why) if words else why == ""


def test_run_records_the_preflight_or_why_there_was_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    protocol = load_protocol("smoke")
    options = replace(flight(DESKTOP).run, out=tmp_path / "S")
    assert _preflight(options, protocol, FACTS) == {
        "without": "there was no preflight of this study"
    }
    said = "note: there was no preflight of this study; to do it, type: vrcomfort preflight smoke "
    assert capsys.readouterr().err.startswith(said)
    done = {**DONE, "headset": "desktop", "protocol": {"name": "smoke", "sha256": protocol.sha256}}
    write_preflight(options.out, done, OWNER)
    held = {"at": done["at"], "outcome": "ok"}
    assert _preflight(options, protocol, FACTS) == held
    assert _preflight(options, protocol, {**FACTS, "gpu": "B"}) == {
        "without": "the GPU was A in the last preflight, and is B now"
    }
    for nobody in (PLAYBACK, OPENXR):
        trace = None if nobody is PLAYBACK else Path("trace.csv")
        without = replace(options, headset=nobody, monado_trace=trace)
        assert _preflight(without, protocol, FACTS) is None


def test_an_operator_who_does_not_go_on_is_told_what_to_type(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vrcomfort.cli.run.ask_to_go_on", lambda _: False)
    options = replace(flight(DESKTOP).run, out=tmp_path / "S")
    words = (
        r"vrcomfort preflight smoke --out .*S --headset desktop, or run again with --no-preflight"
    )
    with pytest.raises(InputError, match=words):
        _preflight(options, load_protocol("smoke"), FACTS)
    on = replace(options, no_preflight=True)
    assert _preflight(on, load_protocol("smoke"), FACTS) is not None


def test_a_damaged_file_is_a_reason_and_a_fault_of_the_study(run: Run, tmp_path: Path) -> None:
    study = tmp_path / "S"
    run("simulate", "smoke", "-n", 1, "--no-draw", "--out", study)
    (study / FILE).write_text('{"at": 3}')
    code, out, _ = run("verify", study)
    assert code == 1
    assert f"{FILE}, line 1" in out
    options = replace(flight(DESKTOP).run, out=study)
    found = _preflight(options, load_protocol("smoke"), FACTS)
    assert found is not None
    assert "damaged" in found["without"]
    (study / FILE).unlink()
    assert run("verify", study)[0] == 0


@pytest.mark.parametrize(
    ("name", "facts", "outcome"),
    [
        ("room", {"room": "2.10 m × 1.60 m"}, "ok"),
        ("room", {"room": "2.10 m × 0.90 m"}, "notice"),
        ("room", {"room": "not told"}, "notice"),
        ("stop", {}, "notice"),
        ("refresh rate", {"refresh_hz": 0.0}, "ok"),
        ("image size", {"image_size_px": [1440, 1600]}, "ok"),
    ],
)
def test_facts_of_a_headset_are_judged(name: str, facts: dict[str, Any], outcome: str) -> None:
    assert outcomes(name, flight(**facts)) == [outcome]


def test_nobody_can_stop_without_controllers_and_looks() -> None:
    about = flight()
    answering = about.protocol.answering.model_copy(update={"stop_by_looks": False})
    about.protocol = about.protocol.model_copy(update={"answering": answering})
    assert outcomes("stop", about) == ["refuse"]


@pytest.mark.parametrize(
    ("renderer", "there", "faster"),
    [
        ("Mesa Intel(R) Iris Xe", ("Intel (8086:1)", "NVIDIA (10de:2)"), ["NVIDIA (10de:2)"]),
        ("NVIDIA GeForce RTX 3060", ("Intel (8086:1)", "NVIDIA (10de:2)"), []),
        ("AMD Radeon RX 7800", ("AMD (1002:1)", "AMD (1002:2)"), []),
        ("llvmpipe (LLVM 19)", ("Intel (8086:1)",), ["Intel (8086:1)"]),
    ],
)
def test_a_faster_gpu_is_named(renderer: str, there: tuple[str, ...], faster: list[str]) -> None:
    assert faster_adapters(renderer, there) == faster


def test_adapters_are_those_of_the_display_class(tmp_path: Path) -> None:
    for place, kind, vendor in (
        ("0000:00:02.0", "0x030000", "0x8086"),
        ("0000:01:00.0", "0x030200", "0x10de"),
        ("0000:02:00.0", "0x020000", "0x8086"),
    ):
        (tmp_path / place).mkdir()
        for name, value in (("class", kind), ("vendor", vendor), ("device", "0x2520")):
            (tmp_path / place / name).write_text(f"{value}\n")
    assert adapters(tmp_path) == ("Intel (8086:2520)", "NVIDIA (10de:2520)")


def test_the_documentation_lists_every_check() -> None:
    page = (ROOT / "docs" / "preflight.md").read_text("utf-8")
    for check in CHECKS:
        assert f"| {check.name} | {check.looks_at} |" in page, check.name
