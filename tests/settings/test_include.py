"""Protocols in several files: what counts, where a fault stands, and what a manifest keeps."""

from __future__ import annotations

import hashlib
import json
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.session import run
from tests.support.study import PROTOCOL, AheadHeadset, LateFocus, Scripted
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol, parse_protocol
from vrcomfort.records import session_folder
from vrcomfort.settings.include import to_toml

HEAD, _, TAIL = PROTOCOL.partition("[[conditions]]")
CONDITIONS, _, ORDER = TAIL.partition("[order]")
SHARED = f"[[conditions]]{CONDITIONS}"
REST = f"[order]{ORDER}"


def write(tmp_path, **files: str):
    (tmp_path / "room.glb").touch()
    for name, text in files.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    return tmp_path / "main.toml"


def test_parts_say_together_what_one_file_says(tmp_path):
    file = write(tmp_path, main=f'include = ["shared.toml"]\n{HEAD}{REST}', shared=SHARED)
    whole = parse_protocol(PROTOCOL, file=tmp_path / "whole.toml")
    assert load_protocol(file).model_dump() == whole.model_dump()


def test_the_resolved_text_is_a_protocol_of_its_own(tmp_path):
    file = write(tmp_path, main=f'include = ["shared.toml"]\n{HEAD}{REST}', shared=SHARED)
    protocol = load_protocol(file)
    again = parse_protocol(protocol.toml, file=tmp_path / "again.toml")
    assert again.model_dump() == protocol.model_dump()
    assert again.sha256 == protocol.sha256


def test_tables_join_lists_of_tables_follow_and_of_the_rest_the_last_counts(tmp_path):
    more = (
        'exposure_s = 99.0\n[[conditions]]\nname = "first"\n'
        "[headset]\nipd_m = 0.06\nrefresh_hz = 72.0\n"
    )
    text = PROTOCOL.replace("[ratings]", "[headset]\nipd_m = 0.07\n[ratings]")
    protocol = load_protocol(write(tmp_path, main=f'include = ["more.toml"]\n{text}', more=more))
    assert protocol.exposure_s == 10.0
    assert [each.name for each in protocol.conditions] == ["first", "plain", "blur"]
    assert (protocol.headset.ipd_m, protocol.headset.refresh_hz) == (0.07, 72.0)


def test_faults_name_the_file_line_and_column_where_they_stand(tmp_path):
    shared = SHARED.replace("[conditions.depth_of_field]", "[conditions.depth_of_fild]")
    main = f'include = ["shared.toml"]\n{HEAD}{REST}'.replace("every_s = 3.0", "every_s = 0.0")
    with pytest.raises(InputError) as caught:
        load_protocol(write(tmp_path, main=main, shared=shared))
    first, second = (caught.value.alone, *caught.value.others)
    assert (first.file, first.line) == (
        tmp_path / "shared.toml",
        shared.splitlines().index("[conditions.depth_of_fild]") + 1,
    )
    assert "did you mean `depth_of_field`" in first.message
    assert (second.file, second.line) == (
        tmp_path / "main.toml",
        main.splitlines().index("every_s = 0.0") + 1,
    )


def test_a_fault_of_a_later_entry_is_found_in_its_own_file(tmp_path):
    more = '[[questionnaires]]\ninstrument = "sqs"\ntimepoint = "again"\nwhen = "session_end"\n'
    file = write(tmp_path, main=f'include = ["more.toml"]\n{PROTOCOL}', more=more)
    with pytest.raises(InputError, match="there is no instrument `sqs`") as caught:
        load_protocol(file)
    assert (caught.value.file, caught.value.line) == (tmp_path / "more.toml", 2)
    bad = PROTOCOL.replace('timepoint = "recovery"', 'timepoint = "recovery"\ninstrument = "sqs"')
    more = more.replace("sqs", "ssq")
    with pytest.raises(InputError, match="there is no instrument `sqs`") as caught:
        load_protocol(write(tmp_path, main=f'include = ["more.toml"]\n{bad}', more=more))
    line = f'include = ["more.toml"]\n{bad}'.splitlines().index('instrument = "sqs"') + 1
    assert (caught.value.file, caught.value.line) == (tmp_path / "main.toml", line)


def test_a_fault_inside_a_table_of_two_files_has_the_line_of_its_own(tmp_path):
    more = "[headset]\nipd_m = 0.06\nrefresh_hz = -72.0\n"
    with pytest.raises(InputError, match="refresh_hz") as caught:
        load_protocol(write(tmp_path, main=f'include = ["more.toml"]\n{PROTOCOL}', more=more))
    assert (caught.value.file, caught.value.line) == (tmp_path / "more.toml", 3)
    more = "[ratings]\nevery_s = 5.0\n"
    main = f'include = ["more.toml"]\n{PROTOCOL}'.replace("every_s = 3.0", "every_s = 0.0")
    with pytest.raises(InputError, match="every_s") as caught:
        load_protocol(write(tmp_path, main=main, more=more))
    line = main.splitlines().index("every_s = 0.0") + 1
    assert (caught.value.file, caught.value.line) == (tmp_path / "main.toml", line)


def test_files_that_include_each_other_are_refused_with_their_chain(tmp_path):
    file = write(
        tmp_path,
        main=f'include = ["a.toml"]\n{PROTOCOL}',
        a='include = ["b.toml"]\n',
        b='# here\ninclude = ["a.toml"]\n',
    )
    with pytest.raises(InputError, match=r"a\.toml → b\.toml → a\.toml; take one") as caught:
        load_protocol(file)
    assert (caught.value.file, caught.value.line) == (tmp_path / "b.toml", 2)


def test_a_part_that_two_include_counts_once(tmp_path):
    file = write(
        tmp_path,
        main=f'include = ["a.toml", "b.toml"]\n{HEAD}{REST}',
        a='include = ["shared.toml"]\n',
        b='include = ["shared.toml"]\n',
        shared=SHARED,
    )
    assert [each.name for each in load_protocol(file).conditions] == ["plain", "blur"]


@pytest.mark.parametrize(
    ("main", "told", "line"),
    [
        ('\ninclude = ["gone.toml"]\n', "there is no file", 2),
        ('include = "shared.toml"\n', "should be a list of files", 1),
        ("include = [1]\n", "should be a list of files", 1),
    ],
)
def test_includes_that_cannot_be_are_refused(tmp_path, main, told, line):
    with pytest.raises(InputError, match=told) as caught:
        load_protocol(write(tmp_path, main=f"{main}{PROTOCOL}"))
    assert caught.value.line == line


def test_a_part_that_is_no_toml_is_told_with_its_own_place(tmp_path):
    file = write(tmp_path, main=f'include = ["a.toml"]\n{PROTOCOL}', a="x = 1\ny = = 2\n")
    with pytest.raises(InputError, match="not valid TOML") as caught:
        load_protocol(file)
    assert (caught.value.file, caught.value.line) == (tmp_path / "a.toml", 2)


def test_a_manifest_holds_the_resolved_text_and_the_hash_of_each_part(tmp_path):
    file = write(tmp_path, main=f'include = ["shared.toml"]\n{HEAD}{REST}', shared=SHARED)
    run(
        load_protocol(file),
        "P01",
        study=tmp_path / "S",
        sessions=[1],
        load_scene=lambda _: None,
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
        respondent=Scripted(),
    )
    folder = session_folder(tmp_path / "S", "P01", 1)
    kept = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["protocol"]
    assert hashlib.sha256(kept["text"].encode()).hexdigest() == kept["sha256"]
    assert tomllib.loads(kept["text"])["conditions"][0]["name"] == "plain"
    assert kept["parts"] == [
        {"file": name, "sha256": hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()}
        for name in ("shared.toml", "main.toml")
    ]


texts = st.text(st.characters(blacklist_categories=["Cs"]), max_size=8)
leaves = st.one_of(
    texts,
    st.integers(-(2**62), 2**62),
    st.booleans(),
    st.floats(allow_nan=False),
)
values = st.recursive(
    leaves,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(texts, inner, max_size=3)),
    max_leaves=8,
)


@pytest.mark.slow
@given(st.dictionaries(texts, values, max_size=5))
def test_what_is_written_as_toml_reads_back(data):
    assert tomllib.loads(to_toml(data)) == data
