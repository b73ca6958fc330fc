"""`vrcomfort status`: who is where, what is next for each and for the study."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.support.resume import go
from tests.support.study import PROTOCOL, Scripted, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.exchange.status import StudyState, status_of
from vrcomfort.records import set_status
from vrcomfort.records.manifest import versions


def steps(state: StudyState) -> dict[str, str]:
    return {person.participant: person.next for person in state.people}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """P01 has one session to come, P02 was interrupted, P03 withdrew, P04 has done all."""
    place = tmp_path_factory.mktemp("recorded")
    go(place)
    go(place, participant="P02", interrupt=(2, 30))
    go(place, Scripted(withdraw_at_s=1.0), participant="P03")
    go(place, participant="P04", sessions=[1, 2])
    return place / "S"


@pytest.fixture
def study(recorded: Path, tmp_path: Path) -> Path:
    """Return a copy that may be changed."""
    return Path(shutil.copytree(recorded, tmp_path / "S"))


def test_each_participant_is_somewhere_and_something_is_next(study: Path) -> None:
    state = status_of(study)
    assert steps(state) == {
        "P01": "session 2",
        "P02": "continue session 1",
        "P03": "",
        "P04": "",
    }
    assert state.statuses == {"enrolled": 2, "withdrawn": 1, "completed": 1}
    first, second, third, fourth = (person.sessions for person in state.people)
    assert (first[0].status, first[0].exposures, first[0].planned) == ("completed", 2, 2)
    assert (second[0].status, second[0].exposures) == ("interrupted", 1)
    assert (third[0].status, third[0].exposures) == ("withdrawn", 0)
    assert [each.number for each in fourth] == [1, 2]
    commands = {person.participant: person.command for person in state.people}
    words = f"vrcomfort run tiny.toml --participant P02 --out {study} --respondent scripted"
    assert commands["P02"] == f"{words} --resume"
    assert commands["P03"] == commands["P04"] == ""
    set_status(study, "P04", "enrolled")
    assert steps(status_of(study))["P04"] == "nothing: all sessions are recorded"


def test_the_next_participant_takes_the_place_of_who_withdrew(tmp_path: Path) -> None:
    sequences = """
[[order.sequences]]
name = "ba"
sessions = [
  [{ scene = "room.glb", condition = "blur" }],
  [{ scene = "room.glb", condition = "plain" }],
]
"""
    text = PROTOCOL.replace("[[questionnaires]]", f"{sequences}\n[[questionnaires]]", 1)
    protocol = tiny_protocol(tmp_path, text)
    go(tmp_path, protocol=protocol)
    assert status_of(tmp_path / "S").next_sequence == "ba"
    go(tmp_path, Scripted(withdraw_at_s=1.0), protocol=protocol, participant="P02")
    state = status_of(tmp_path / "S")
    assert (state.next_sequence, state.places) == ("ba", 1)
    set_status(tmp_path / "S", "P01", "excluded")
    assert status_of(tmp_path / "S").next_sequence == "ab"


def test_the_disk_and_the_versions_are_those_of_the_folder(study: Path) -> None:
    state = status_of(study)
    assert state.bytes_used == sum(f.stat().st_size for f in study.rglob("*") if f.is_file())
    assert state.bytes_free > 0
    assert sum(state.schema_versions.values()) == 5
    assert state.versions == {versions()["vrcomfort"]: 5}


def test_a_damaged_session_is_told_and_the_others_shown(study: Path, run) -> None:
    manifest = study / "sub-P01" / "ses-1" / "manifest.json"
    manifest.write_text(manifest.read_text()[:100])
    state = status_of(study)
    assert steps(state)["P01"] == "session 1 is damaged: vrcomfort verify says what to do"
    assert steps(state)["P02"] == "continue session 1"
    code, out, _ = run("status", study)
    assert code == 0
    assert f"P01, session 1: {manifest}, line" in out


def test_the_command_answers_people_and_programs(study: Path, run) -> None:
    code, out, err = run("status", study)
    assert (code, err) == (0, "")
    assert "P02, continue session 1: vrcomfort run tiny.toml --participant P02" in out
    assert "Participants: 2 enrolled, 1 withdrawn, 1 completed; 3 take a place" in out
    assert "Next new participant: sequence ab" in out
    said = json.loads(run("status", study, "--json")[1])
    assert [person["participant"] for person in said["people"]] == ["P01", "P02", "P03", "P04"]
    assert said["people"][1]["sessions"][0]["status"] == "interrupted"


def test_what_is_no_study_is_refused_in_a_sentence(run, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is not a study folder"):
        status_of(tmp_path)
    (tmp_path / "import.json").write_text("{}")
    code, _, err = run("status", tmp_path)
    assert (code, err.count("\n")) == (2, 1)
    assert "this is an import, which has no sessions" in err
