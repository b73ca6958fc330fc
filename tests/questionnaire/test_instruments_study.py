"""Studies without an SSQ: instruments of a lab's own are asked, kept, scored and reported."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

from tests.support.places import ROOT
from tests.support.report import HEAD, WITHOUT_MODELS, build_report, results_of
from tests.support.session import run
from tests.support.study import PROTOCOL, AheadHeadset, LateFocus, read_rows, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.questionnaire import parse_instrument, score_file, shipped_instruments
from vrcomfort.respondent import SimulatedRespondent

DOCS = (ROOT / "docs" / "instruments.md").read_text(encoding="utf-8")
OWN = re.findall(r"```toml\n(name = .*?)```", DOCS, re.DOTALL)[0]
"""The instrument that the docs show."""

BOTH = PROTOCOL.replace(
    '[[questionnaires]]\ntimepoint = "post"',
    '[[questionnaires]]\ninstrument = "room.toml"\ntimepoint = "post"\nwhen = "after_trial"\n\n'
    '[[questionnaires]]\ninstrument = "vrsq"\ntimepoint = "post"',
).replace('[[questionnaires]]\ntimepoint = "baseline"', '[[questionnaires]]\ninstrument = "vrsq"\n'
          'timepoint = "baseline"').replace('[[questionnaires]]\ntimepoint = "recovery"',
          '[[questionnaires]]\ninstrument = "vrsq"\ntimepoint = "recovery"')  # fmt: skip


def protocol_of(folder: Path, text: str = BOTH, own: str = OWN) -> Protocol:
    (folder / "room.toml").write_text(own, encoding="utf-8")
    return tiny_protocol(folder, text)


def simulated(folder: Path, protocol: Protocol, people: int = 1) -> Path:
    for number in range(people):
        name = f"P{number + 1:02d}"
        outcome = run(
            protocol,
            name,
            study=folder / "S",
            load_scene=lambda source: source,
            headset_for=lambda *_: AheadHeadset(),
            renderer=LateFocus(),
            respondent=SimulatedRespondent(protocol.simulation, participant=name, seed=3),
        )
        assert outcome.status == "completed"
    return folder / "S"


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("own")
    return simulated(folder, protocol_of(folder), people=3)


def test_a_study_asks_instruments_in_the_order_of_the_protocol_and_keeps_the_labs_own(study):
    rows = read_rows(study / "sub-P01/ses-1/questionnaires.csv")
    assert {row["instrument"] for row in rows} == {"vrsq", "room_quality"}
    first = [r["item"] for r in rows if r["timepoint"] == "post" and r["trial"] == "1"]
    assert first[:3] == ["felt_there", "felt_flat", "would_return"]
    assert first[3:] == [item.name for item in shipped_instruments()["vrsq"].items]
    assert all(1 <= int(r["response"]) <= 5 for r in rows if r["instrument"] == "room_quality")
    assert (study / "instruments/room_quality.toml").read_text(encoding="utf-8") == OWN
    assert not (study / "instruments/vrsq.toml").exists()


def test_the_report_has_the_scores_of_both_and_no_word_of_an_ssq(study, tmp_path):
    build_report(study, out=tmp_path)
    results = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert [each["name"] for each in results["outcomes"]] == [
        "room_quality.presence", "room_quality.would_return",
        "vrsq.total", "vrsq.oculomotor", "vrsq.disorientation",
    ]  # fmt: skip
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "SSQ" not in re.sub(r"VRSQ|data:[^\"]*", "", page)
    assert "Simulator Sickness" not in page
    assert "Room quality" in page
    assert "Presence" in page
    with (tmp_path / "tables/scores.csv").open(encoding="utf-8") as stream:
        row = next(csv.DictReader(stream))
    assert {"vrsq.total_raw", "vrsq.total", "vrsq.headache", "room_quality.felt_flat"} <= set(row)
    assert float(row["room_quality.presence"]) == int(row["room_quality.presence_raw"]) / 2


def test_of_one_instrument_a_plan_without_outcomes_takes_those_that_the_data_have(study, tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text(HEAD + WITHOUT_MODELS)
    results = results_of(build_report(study, plan=plan, out=tmp_path / "o", instrument="vrsq"))
    names = ["vrsq.total", "vrsq.oculomotor", "vrsq.disorientation"]
    assert [each["name"] for each in results["outcomes"]] == results["plan"]["outcomes"] == names
    assert {test["outcome"] for test in results["tests"]} == set(names)
    with pytest.raises(InputError, match="has no answers to the SSQ"):
        build_report(study, out=tmp_path, instrument="ssq")


def test_the_scores_of_the_study_are_those_of_its_file(study):
    file = study / "sub-P01/ses-1/questionnaires.csv"
    found = score_file(file, parse_instrument(OWN)).rows
    rows = [r for r in read_rows(file) if r["instrument"] == "room_quality" and r["trial"] == "1"]
    answers = {row["item"]: int(row["response"]) for row in rows}
    assert found[0]["presence"] == (answers["felt_there"] + 6 - answers["felt_flat"]) / 2


def test_a_study_is_not_continued_with_another_text_of_its_instrument(tmp_path):
    study = simulated(tmp_path, protocol_of(tmp_path))
    changed = protocol_of(tmp_path, own=OWN.replace("looked flat", "looked very flat"))
    assert study.is_dir()
    with pytest.raises(InputError, match="begun with another text of `room_quality`"):
        simulated(tmp_path, changed, people=2)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"room.toml"', '"rooms.toml"', "there is no such instrument file; check the path"),
        ('"vrsq"', '"vrqs"', "there is no instrument `vrqs`; did you mean `vrsq`"),
        ('"fms"', '"vrsq"', "the VRSQ has 9 items; a rating is one question"),
        ('instrument = "vrsq"', 'instrument = "vrsq"\nlanguage = "de"', "no complete wording in"),
        ("stop_at = 15", "stop_at = 21", "the FMS goes from 0 to 20"),
    ],
)
def test_an_instrument_that_cannot_be_asked_is_a_fault_of_the_protocol(tmp_path, old, new, says):
    assert old in BOTH
    with pytest.raises(InputError) as caught:
        protocol_of(tmp_path, BOTH.replace(old, new))
    assert says in caught.value.message
    assert caught.value.file == tmp_path / "tiny.toml"
    assert caught.value.line is not None


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("high = 5", "high = 102", "has 102 answers; give an `asked_step` with at most 101"),
        ("low = 1", "low = -5", "has answers that cannot be typed"),
        ("high = 5", "high = 5\nstep = 0.5", "has answers that cannot be typed"),
        ('"not at all", "completely"', '"a", "b", "c"', "room.toml, line 8"),
    ],
)
def test_a_form_that_the_panel_cannot_show_is_refused(tmp_path, old, new, says):
    with pytest.raises(InputError) as caught:
        protocol_of(tmp_path, own=OWN.replace(old, new))
    assert says in str(caught.value)


def test_a_translation_is_asked_in_its_language(tmp_path):
    words = "\n".join(f'{name} = "{name} auf Deutsch"' for name in ("felt_there", "felt_flat"))
    german = (
        f'{OWN}\n[translations.de]\ninstruction = "Wie sehr?"\n'
        f'labels = ["gar nicht", "völlig"]\n[translations.de.items]\n{words}\n'
        'would_return = { text = "Gerne wieder", aliases = ["Wieder"] }\n'
    )
    ask = 'instrument = "room.toml"\nlanguage = "de"'
    protocol = protocol_of(tmp_path, BOTH.replace('instrument = "room.toml"', ask), german)
    form = protocol.form(next(iter(protocol.asks("after_trial", 1, 1))))
    assert form.instruction == "Wie sehr?"
    assert form.items[0].answers.labels == ("gar nicht", "völlig")
    assert [item.text for item in form.items][2] == "Gerne wieder"
    assert protocol.instrument("room_quality").item("Wieder").name == "would_return"


def test_weights_are_not_asked(tmp_path):
    text = BOTH.replace('"room.toml"', '"nasa_tlx"')
    protocol = protocol_of(tmp_path, text)
    form = protocol.form(next(iter(protocol.asks("after_trial", 1, 1))))
    assert len(form.items) == 6
    study = simulated(tmp_path, protocol)
    rows = read_rows(study / "sub-P01/ses-1/questionnaires.csv")
    said = [int(row["response"]) for row in rows if row["instrument"] == "nasa_tlx"]
    assert len(said) == 2 * 6
    assert all(answer % 5 == 0 for answer in said)


def test_the_table_in_the_docs_is_what_the_example_comes_to(tmp_path):
    block = re.search(r"```text\n(participant.*?)```", DOCS, re.DOTALL)
    file = tmp_path / "room.csv"
    file.write_text(
        "participant,condition,felt_there,felt_flat,would_return\n"
        "P1,off,4,2,5\nP1,on,5,1,5\nP2,off,2,4,3\n",
        encoding="utf-8",
    )
    rows = score_file(file, parse_instrument(OWN)).rows
    lines = [",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]
    assert block is not None
    assert block[1].splitlines() == lines


def test_the_docs_name_every_shipped_instrument_and_its_citation():
    for name, instrument in shipped_instruments().items():
        assert f"`{name}`" in DOCS
        title = re.split(" with |, short form", instrument.title)[0]
        assert title.casefold() in DOCS.casefold()
