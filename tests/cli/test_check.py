"""`vrcomfort check`, the session without pictures, and whether a number balances a design."""

from __future__ import annotations

import json
import re

import pytest

from tests.support.protocols import GROUPS, generated
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.design import build_design
from vrcomfort.design.audit import cannot_balance
from vrcomfort.errors import InputError
from vrcomfort.gpu import gl
from vrcomfort.protocol import load_protocol
from vrcomfort.resources import data_folder
from vrcomfort.session.dry_run import dry_run

SHIPPED = sorted(path.stem for path in data_folder("protocols").glob("*.toml"))


def test_a_session_without_pictures_takes_its_time(tmp_path):
    first, second = dry_run(tiny_protocol(tmp_path), tmp_path)
    for number, each in enumerate((first, second), start=1):
        assert (each.session, each.sequence, each.group) == (number, "ab", "")
        assert each.exposure_s == pytest.approx(20.0, abs=1e-6)
        assert each.training_s == pytest.approx(1.0, abs=1e-6)
        assert each.rest_s == 60.0
        assert each.questions_s > 4 * 16  # four questionnaires of 16 questions
        parts = each.exposure_s + each.training_s + each.rest_s + each.questions_s
        assert each.total_s == pytest.approx(parts)


def test_a_session_without_pictures_asks_everything(tmp_path):
    dry_run(tiny_protocol(tmp_path), tmp_path)
    folder = tmp_path / "dry_run" / "sub-P01" / "ses-2"
    questions = (folder / "questionnaires.csv").read_text(encoding="utf-8").splitlines()
    assert len(questions) == 1 + 4 * 16
    ratings = (folder / "ratings.csv").read_text(encoding="utf-8").splitlines()
    assert len(ratings) == 1 + 2 * 2  # every 3 s, of 10 s, with 2 s to answer


def test_every_group_is_rehearsed(tmp_path):
    lengths = dry_run(generated("williams", 4, "", GROUPS), tmp_path)
    assert sorted(each.group for each in lengths) == ["far", "near"]


@pytest.mark.parametrize(
    ("participants", "says"),
    [
        (20, None),
        (8, None),
        (6, "6 participants do not divide by 4 sequences.*; choose 4 or 8"),
        (3, "choose 4, or another rule"),
    ],
)
def test_whether_a_number_balances_a_design(participants, says):
    found = cannot_balance(build_design(generated("williams", 4)), participants)
    assert_said(found, says)


@pytest.mark.parametrize(
    ("share", "participants", "says"),
    [
        (1, 8, None),
        (1, 6, "6 participants do not divide by 4 sequences of 2 groups.*choose 4 or 8"),
        (1, 7, "7 participants cannot be divided among 2 equal groups; choose 6 or 8"),
        (2, 6, None),
        (2, 9, "9 participants do not divide .*choose 6 or 12"),
        (2, 4, "among groups of shares 2 : 1; choose 3 or 6"),
    ],
)
def test_groups_must_divide_as_well(share, participants, says):
    tables = GROUPS.replace('name = "near"', f'name = "near"\nshare = {share}')
    found = cannot_balance(build_design(generated("williams", 4, "", tables)), participants)
    assert_said(found, says)


def assert_said(found, says):
    if says is None:
        assert found is None
    else:
        assert re.search(says, found)


def test_random_orders_balance_with_any_number():
    assert cannot_balance(build_design(generated("random", 5)), 7) is None


@pytest.mark.smoke
def test_a_good_protocol_has_no_fault(run):
    code, out, _ = run("check", "smoke", "--no-draw")
    assert code == 0
    assert "smoke: nothing is wrong" in out
    assert "length of sessions" in out


def test_every_protocol_is_checked_and_every_fault_told(run, tmp_path):
    smoke = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    odd = tmp_path / "odd.toml"
    odd.write_text(smoke.replace("participants = 4", "participants = 5"), encoding="utf-8")
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(smoke.replace("exposure_s", "exposre_s"), encoding="utf-8")
    code, out, err = run("check", odd, wrong, "smoke", "--no-draw")
    assert code == 2
    assert "odd.toml, line 6, column 1: 5 participants do not divide by 4 sequences" in err
    assert "did you mean `exposure_s`?" in err
    assert "smoke: nothing is wrong" in out
    code, out, _ = run("check", odd, "smoke", "--no-draw", "--json")
    assert code == 2
    found = json.loads(out)
    assert len(found[str(odd)]["faults"]) == 1
    assert found["smoke"]["faults"] == []
    assert found["smoke"]["stimuli"] is None
    assert found["smoke"]["sessions"][0]["exposure_s"] == pytest.approx(0.4, abs=0.01)


def test_a_machine_without_opengl_is_told(run, monkeypatch):
    def no_context():
        raise InputError("no OpenGL")

    monkeypatch.setattr(gl, "create_context", no_context)
    code, _, err = run("check", "smoke")
    assert code == 0
    assert "blur and streaks were not measured: no OpenGL" in err


def test_an_instrument_without_scales_is_told(run, tmp_path):
    (tmp_path / "room.glb").touch()
    (tmp_path / "mine.toml").write_text(
        'name = "mine"\ntitle = "Mine"\nanswers = { low = 0, high = 3 }\n'
        '[[items]]\nname = "one"\ntext = "One?"\n[[items]]\nname = "two"\ntext = "Two?"\n',
        encoding="utf-8",
    )
    protocol = tmp_path / "p.toml"
    asked = 'timepoint = "recovery"\ninstrument = "mine.toml"'
    protocol.write_text(PROTOCOL.replace('timepoint = "recovery"', asked), encoding="utf-8")
    code, _, err = run("check", protocol, "--no-draw")
    assert code == 0
    assert "has no [[scales]]: its items are reported one by one" in err
    assert "`participants` is not said" in err


def test_unknown_conditions_of_visibility_are_told(tmp_path):
    for written in ('unseen = ["blurr"]', 'alike = [["plain", "blurr"]]'):
        with pytest.raises(InputError, match=r"no condition `blurr`; did you mean `blur`\?"):
            tiny_protocol(tmp_path, f"{PROTOCOL}[visibility]\n{written}\n")


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_protocols_last_as_planned_are_seen_and_have_nothing_to_note(run, name):
    code, out, err = run("check", name, "--json", "--moments", 6)
    assert code == 0, err
    found = json.loads(out)[name]
    assert (found["faults"], found["notes"]) == ([], [])
    protocol = load_protocol(name)
    planned = build_design(protocol).plan(1)[0].sessions
    for lasts, session in zip(found["sessions"], planned, strict=True):
        most_s = sum(protocol.length_s(trial.scene) for trial in session)
        assert 0 < lasts["exposure_s"] < most_s + 0.1  # adjusting may end earlier
    rows = found["stimuli"]
    assert len(rows) == len(protocol.conditions) * len(protocol.scenes)
    for row in rows:
        condition = protocol.condition(row["condition"])
        assert (row["circles"] is None) == (condition.depth_of_field is None)
        assert (row["streaks"] is None) == (condition.motion_blur is None)
        shown = [row[kind]["p90_px"] for kind in ("circles", "streaks") if row[kind]]
        if shown and row["condition"] not in protocol.visibility.unseen:
            assert max(shown) >= 1.0


@pytest.mark.slow
def test_a_condition_that_nobody_can_see_is_refused(run, tmp_path):
    smoke = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    weak = smoke.replace('law = "dioptre"', 'law = "eye"\npupil_mm = 0.1')
    (tmp_path / "weak.toml").write_text(weak, encoding="utf-8")
    code, _, err = run("check", tmp_path / "weak.toml", "--moments", 4)
    assert code == 2
    assert "weak.toml, line 16, column 1: `dof` cannot be seen in temple" in err
    meant = f'{weak}[visibility]\nunseen = ["dof"]\n'
    (tmp_path / "meant.toml").write_text(meant, encoding="utf-8")
    assert run("check", tmp_path / "meant.toml", "--moments", 4)[0] == 0


@pytest.mark.slow
def test_a_scene_without_a_walk_is_looked_at_all_around(run, tmp_path):
    scene = data_folder("scenes") / "temple.glb"
    (tmp_path / "mine.glb").write_bytes(scene.read_bytes())
    smoke = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    file = tmp_path / "p.toml"
    file.write_text(smoke.replace('scenes = ["temple"]', 'scenes = ["mine.glb"]'), encoding="utf-8")
    code, out, _ = run("check", file, "--moments", 4, "--json")
    assert code == 0
    rows = {row["condition"]: row for row in json.loads(out)[str(file)]["stimuli"]}
    assert rows["motion"]["streaks"]["p90_px"] > 1
    assert rows["dof"]["circles"]["p90_px"] > 1
