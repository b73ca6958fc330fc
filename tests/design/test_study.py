"""The audit of what was run, and who is enrolled in which group."""

from __future__ import annotations

import json
import re
from collections import Counter

import pytest

from tests.support.protocols import (
    ASKED_AFTER_EACH,
    COVARIATES,
    generated,
    grouped,
    protocol_text,
)
from tests.support.study import read_rows, tiny_protocol
from vrcomfort.design import AdministeredOrder, Enrolment, audit_study, build_design
from vrcomfort.errors import InputError
from vrcomfort.protocol import Sequence
from vrcomfort.records import administered_orders, enrol, open_study, read_participants, set_status
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.rows import cell_text, csv_line
from vrcomfort.records.study import enrolment_of
from vrcomfort.resources import data_folder

KNOWN = {"sex": "male", "age": "20", "susceptibility": "low"}
ALLOCATION = 'rounds = [1]\nby = ["sex"]'


def met(design, name, status="completed", exposures=None):
    whole = design.sequence(name)
    sessions = tuple(session[:exposures] for session in whole.sessions)
    return AdministeredOrder(name, Enrolment(name, status), Sequence.model_construct(name=name, group=whole.group, sessions=sessions))  # fmt: skip  # noqa: E501


def test_the_audit_of_what_was_run_counts_what_was_shown_whole():
    design = build_design(generated("williams", 4))
    found = audit_study(design, [met(design, "s1"), met(design, "s2", "enrolled", exposures=2)])
    assert found.participants == 2
    assert sum(sum(each) for each in found.counted.conditions.positions.values()) == 6
    assert sum(found.counted.treatments.carry_over.values()) == 3 + 1
    assert found.next_orders == ("s3", "s4")
    assert "next 2 participants get s3, s4" in found.mending
    assert found.after.treatments.even_positions
    assert found.after.treatments.even_carry_over


def test_places_of_those_who_are_gone_are_mended():
    design = build_design(generated("williams", 4))
    everybody = [met(design, f"s{n}", "withdrawn" if n == 2 else "completed") for n in (1, 2, 3, 4)]
    found = audit_study(design, everybody)
    assert found.gone == {"s2": 1}
    assert found.next_orders == ("s2",)
    assert "next 1 participant gets s2" in found.mending
    assert design.assign(each.enrolment for each in everybody).name == "s2"
    assert not found.counted.treatments.even_positions


def test_the_orders_that_mend_are_those_that_are_assigned_next():
    design = build_design(generated("williams", 5), seed=2)
    everybody = [met(design, each.name) for each in design.plan(13)]
    gone = {1, 5, 6}
    everybody = [
        met(design, each.enrolment.sequence, "excluded" if index in gone else "completed")
        for index, each in enumerate(everybody)
    ]
    enrolments = [each.enrolment for each in everybody]
    found = audit_study(design, everybody)
    nexts = [each.name for each in design.continued(enrolments, len(found.next_orders))]
    assert sorted(nexts) == sorted(found.next_orders)


def test_nothing_to_mend_is_said():
    design = build_design(generated("williams", 4))
    found = audit_study(design, [met(design, each.name) for each in design.plan(8)])
    assert found.next_orders == ()
    assert "Nothing has to be mended" in found.mending
    random = build_design(generated("random", 4))
    assert "nothing to mend" in audit_study(random, [met(random, "r1")]).mending


def test_kept_places_are_said():
    design = build_design(generated("williams", 4, "return_places = false\n"))
    found = audit_study(design, [met(design, "s1", "withdrawn"), met(design, "s2")])
    assert found.next_orders == ("s3", "s4")
    assert "1 who are gone keep their places" in found.mending


def write_trials(folder, rows):
    folder.mkdir(parents=True)
    blank = dict.fromkeys(TrialRow.columns(), "")
    lines = [csv_line(TrialRow.columns())]
    lines += [csv_line(map(cell_text, {**blank, **row}.values())) for row in rows]
    (folder / "trials.csv").write_text("".join(lines), encoding="utf-8")


def test_what_was_met_is_read_from_the_study(tmp_path):
    protocol, study = grouped(ALLOCATION), tmp_path / "S"
    design = build_design(protocol)
    open_study(study, protocol)
    rows = [enrol(study, design, f"P{n}", KNOWN) for n in range(4)]
    assert {row.group for row in rows} == {"near", "far"}
    shown = {"condition": "c1", "scene": "room.gltf"}
    trials = [{**shown, "status": "aborted"}, {**shown, "status": "completed"}]
    write_trials(study / "sub-P0" / "ses-1", trials)
    first, *others = administered_orders(study)
    assert [trial.condition for trial in first.run.trials] == ["c1"]
    assert first.enrolment.covariates == KNOWN
    assert all(each.run.trials == () for each in others)
    found = audit_study(design, [first, *others])
    assert found.counted.groups == {"near": 2, "far": 2}
    assert found.margins["sex"]["male"] == {"near": 2, "far": 2}
    assert found.margins["sex"]["female"] == {"near": 0, "far": 0}


def test_groups_and_covariates_are_columns_of_the_participants(tmp_path):
    protocol, study = grouped(ALLOCATION), tmp_path / "S"
    design = build_design(protocol)
    open_study(study, protocol)
    first = enrol(study, design, "P01", KNOWN)
    (row,) = read_rows(study / "participants.csv")
    assert row == {
        "participant": "P01", "sequence": first.sequence, "status": "enrolled",
        "enrolled_at": first.enrolled_at, "note": "", "group": first.group, **KNOWN,
    }  # fmt: skip
    assert enrol(study, design, "P01") == first
    assert enrol(study, design, "P01", {"age": "20"}) == first
    set_status(study, "P01", "withdrawn", "sick")
    (kept,) = read_participants(study)
    assert (kept.status, kept.covariates) == ("withdrawn", KNOWN)
    assert enrolment_of(kept) == Enrolment(first.sequence, "withdrawn", KNOWN)


def test_covariates_that_do_not_fit_are_refused_before_anybody_is_enrolled(tmp_path):
    protocol, study = grouped(ALLOCATION), tmp_path / "S"
    design = build_design(protocol)
    open_study(study, protocol)
    with pytest.raises(InputError, match=r"add --covariate sex=female\|male"):
        enrol(study, design, "P01")
    assert read_participants(study) == []
    enrol(study, design, "P01", KNOWN)
    with pytest.raises(InputError, match="enrolled with age = 20, not 21"):
        enrol(study, design, "P01", {"age": "21"})


def test_the_command_draws_orders_with_the_seed_that_is_given(tmp_path, run):
    text = protocol_text(
        ASKED_AFTER_EACH,
        conditions=[f'[[conditions]]\nname = "c{n}"\n' for n in range(6)],
        order='[order]\nrule = "random"\n',
    )
    protocol = tiny_protocol(tmp_path, text).file
    orders = [run("design", protocol, "--json", *more)
              for more in ((), ("--seed", 0), ("--seed", 5))]  # fmt: skip
    assert [code for code, _, _ in orders] == [0, 0, 0]
    assert orders[0] == orders[1] != orders[2]


def test_design_of_a_study_on_the_command_line(tmp_path, run):
    (tmp_path / "room.glb").touch()
    protocol = tmp_path / "p.toml"
    protocol.write_text(grouped(ALLOCATION).toml.replace(".gltf", ".glb"), encoding="utf-8")
    code, out, _ = run("design", protocol, "-n", 8)
    assert code == 0
    assert "Groups" in out
    (first,) = [line for line in out.splitlines() if "P01" in line]
    assert re.search(r"P01 .* (near|far) ", first)
    assert "Covariates of the people above were drawn" in " ".join(out.split())
    code, out, _ = run("design", protocol, "-n", 8, "--json")
    assert sum(json.loads(out)["groups"].values()) == 8

    from vrcomfort.protocol import load_protocol

    read = load_protocol(protocol)
    open_study(tmp_path / "S", read, seed=4)
    design = build_design(read, seed=4)
    names = [enrol(tmp_path / "S", design, f"P{n}", KNOWN).sequence for n in range(3)]
    set_status(tmp_path / "S", "P0", "withdrawn", "sick")
    code, out, _ = run("design", protocol, "--study", tmp_path / "S")
    words = " ".join(out.split())
    assert code == 0
    assert "3 enrolled, 2 take a place" in words
    assert f"1 of sequence {names[0]} withdrew" in words
    assert "Groups by sex" in words
    assert "All sequences are filled alike once the next 2 participants get" in words
    code, out, _ = run("design", protocol, "--study", tmp_path / "S", "--json")
    assert names[0] in json.loads(out)["next_orders"]
    code, _, err = run("design", protocol, "--study", tmp_path)
    assert code == 2
    assert "this is not a study folder" in err
    code, _, err = run("run", protocol, "--participant", "P9", "--out", tmp_path / "S", "--covariate", "age")  # fmt: skip  # noqa: E501
    assert code == 2
    assert "write NAME=VALUE" in err


@pytest.mark.slow
def test_simulated_participants_come_into_groups(tmp_path, run):
    smoke = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    groups = (
        '[[groups]]\nname = "calm"\nconditions = ["plain", "dof"]\n'
        '[[groups]]\nname = "moved"\nconditions = ["motion", "both"]\n'
    )
    tables = f'{groups}{COVARIATES}[allocation]\nrounds = [1]\nby = ["sex"]\n[order]'
    file = tmp_path / "grouped.toml"
    file.write_text(smoke.replace("[order]", tables), encoding="utf-8")
    code, _, err = run("simulate", file, "-n", 4, "--out", tmp_path / "S", "--size", "32x32")
    assert code == 0, err
    people = read_rows(tmp_path / "S" / "participants.csv")
    shown = {"calm": {"plain", "dof"}, "moved": {"motion", "both"}}
    difference = Counter()
    for person in people:
        trials = read_rows(tmp_path / "S" / f"sub-{person['participant']}" / "ses-1/trials.csv")
        assert {trial["condition"] for trial in trials} <= shown[person["group"]]
        assert 18 <= int(person["age"]) <= 70
        difference[person["sex"]] += 1 if person["group"] == "calm" else -1
        assert abs(difference[person["sex"]]) <= 1
    code, out, _ = run("design", file, "--study", tmp_path / "S", "--json")
    assert code == 0
    assert sum(json.loads(out)["counted"]["groups"].values()) == 4
