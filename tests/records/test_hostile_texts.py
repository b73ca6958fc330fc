"""Whatever people type is kept harmless: no row that is damaged, no session that it ends."""

from __future__ import annotations

import errno
import inspect
import io
import json
import os
import re
import sys
from functools import partial
from importlib import import_module
from pathlib import Path

import pytest
import typer

from tests.console.test_control import steered
from tests.questionnaire.test_free_texts import Says, tell
from tests.support import resume
from tests.support.operator import Wanted
from tests.support.study import Scripted
from vrcomfort import cli
from vrcomfort.cli.app import COMMANDS
from vrcomfort.console.server import read_command
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.json_text import json_of, parse_json
from vrcomfort.protocol import load_protocol
from vrcomfort.records import Study, read_participants
from vrcomfort.records.participants import add_note, exclude, undo_exclusion
from vrcomfort.records.rows import csv_line
from vrcomfort.report.study_data import read_study

go = partial(resume.go, exposure_s=1.0)

TEXTS = {
    "half a character": "a\ud800b",
    "Latin-1 bytes": os.fsdecode(b"M\xfcller"),
    "two halves": "\ud83d\ude00",
    "NUL": "a\0b",
    "ends of lines": "a\r\nb\x85c\u2028d\x0be\x1ef",
    "escape sequences": "\x1b[31mred\x07\x7f",
    "signs of CSV": 'a,"b";\t=1+1',
}  # fmt: skip
BREAKING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
MIXED = "".join(TEXTS.values())
texts = pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)

RECORDED = {"text", "reason", "title"}
"""Parameters of commands that take any text and keep it."""
CHECKED = {
    "answers", "beside", "cluster", "compare", "condition", "consent", "consented_on", "covariate",
    "effect", "effects", "eye", "figures", "format", "instrument", "kind", "language", "lens",
    "memory", "methods", "page",
    "participant", "participants", "plan", "pose", "previous_pose", "protocol", "protocols",
    "questionnaire", "rating", "scene", "settings", "show", "size", "trial",
    "trust", "ttl", "without",
}  # fmt: skip
"""Parameters that name a file, or one of a few things that there are."""


def assert_harmless(study: Path) -> None:
    """Everything in a study is one row a line, and is read again."""
    for file in study.rglob("*.csv"):
        assert not BREAKING.search(file.read_bytes().decode()), file
        table = CsvTable.read(file)
        assert table.lines == tuple(range(2, len(table.rows) + 2)), file
    for file in study.rglob("*.json"):
        parse_json(file.read_text("utf-8"), file)
    assert [str(each) for each in verify_study(study).faults] == []
    read_study(study)


def test_every_parameter_that_takes_a_text_is_tried_here_or_checked():
    every = typer.Typer()
    for name in {each.module for each in COMMANDS.values()}:
        import_module(f"vrcomfort.cli.{name}").register(every)
    assert len(every.registered_commands) == len(COMMANDS)
    names = {
        name
        for command in every.registered_commands
        for name, known in inspect.signature(command.callback, eval_str=True).parameters.items()
        if "str" in str(known.annotation)
    }
    assert names == RECORDED | CHECKED


@texts
def test_a_text_is_visible_and_stays_what_it_is(text):
    assert not BREAKING.search(escape_unprintable(text))
    assert escape_unprintable(escape_unprintable(text)) == escape_unprintable(text)
    assert escape_unprintable("Müller 漢字 🙂 \\n\t\n") == "Müller 漢字 🙂 \\n\t\n"


@texts
def test_any_row_and_any_json_can_be_read_again(text, tmp_path):
    file = tmp_path / "t.csv"
    file.write_text(csv_line(["one", text]) + csv_line([text * 50_000, 2]), "utf-8")
    with file.open("a", encoding="utf-8") as stream:
        stream.write(csv_line([text, None]))
    assert len(CsvTable.read(file).rows) == 2
    content = parse_json(json_of({text: [text]}), file)
    assert json.dumps(content, ensure_ascii=False).encode()


def test_notes_and_reasons_of_an_experimenter(tmp_path, run):
    go(tmp_path, respondent=Scripted(withdraw_at_s=0.5))
    study = tmp_path / "S"
    for command, *rest in (
        ("undo-withdrawal", "P01", "--reason", MIXED),
        ("note", "P01", MIXED),
        ("exclude", "P01", "--reason", MIXED),
        ("undo-exclusion", "P01", "--reason", MIXED),
    ):
        code, _, err = run(command, study, *rest)
        assert (code, err) == (0, ""), command
    assert_harmless(study)
    (row,) = read_participants(study)
    assert row.note.count(" ".join(escape_unprintable(MIXED).splitlines())) >= 4
    go(tmp_path, resume=True)
    assert_harmless(study)


def test_texts_of_the_console(tmp_path):
    steered(
        tmp_path,
        Wanted("exposure", "note", MIXED),
        Wanted("exposure", MIXED),
        Wanted("exposure", "abort", MIXED),
    )
    assert_harmless(tmp_path / "S")


@texts
def test_a_message_of_the_consoles_page(text):
    message = json.dumps({"id": text, "action": text, "step": 1, "text": text})
    entered = read_command(message)
    assert not isinstance(entered, str)
    assert not BREAKING.search("".join([entered.id, entered.action, entered.text]))


def test_a_reason_to_withdraw_of_the_console(tmp_path):
    steered(tmp_path, Wanted("exposure", "withdraw", MIXED),
            Wanted("exposure", "withdraw_surely", MIXED))  # fmt: skip
    assert_harmless(tmp_path / "S")


def test_answers_in_own_words(tmp_path):
    tell(tmp_path, Says(MIXED, MIXED, MIXED))
    assert_harmless(tmp_path / "S")


def test_the_title_of_a_new_protocol(tmp_path, run, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = run("new", "mine", "--title", f"a\nb = 1 {MIXED}", "--yes")
    assert (code, err) == (0, "")
    assert load_protocol(tmp_path / "mine.toml").title.startswith("a b = 1 ")


def test_a_text_that_no_note_can_hold_is_refused(tmp_path):
    go(tmp_path)
    study = tmp_path / "S"
    with pytest.raises(InputError, match="has 20,001 characters, and a note at most 20,000"):
        add_note(study, "P01", "x" * 20_001)
    for _ in range(4):
        add_note(study, "P01", "x" * 19_000)
    with pytest.raises(InputError, match=r"notes on P01 have 76,1\d\d characters and are full"):
        exclude(study, "P01", "y" * 19_000)
    exclude(study, "P01", "short")
    undo_exclusion(study, "P01", "y")
    assert_harmless(study)


LATIN = os.fsdecode(b"st\xfcdy")
ON_A_FOLDER = [
    ["status"],
    ["status", "--json"],
    ["verify"],
    ["pack"],
    ["note", "P01", "x"],
    ["report", "--figures", "none", "--out", f"report {LATIN}"],
    ["anonymise", "--out", f"anonymous {LATIN}"],
    ["export", "--format", "psych-ds", "--out", f"psych {LATIN}"],
    ["export", "--format", "bids", "--out", f"bids {LATIN}"],
]


def test_a_folder_whose_name_is_no_utf8(tmp_path, run, monkeypatch):
    monkeypatch.chdir(tmp_path)
    go(tmp_path, study=LATIN)
    for words in ON_A_FOLDER:
        assert run(words[0], LATIN, *words[1:])[0] == 0, words


def test_a_recording_below_a_folder_that_the_database_does_not_take(tmp_path, run):
    go(tmp_path, study=LATIN)
    frames = Study(tmp_path / LATIN).frames.df()
    assert run("pack", tmp_path / LATIN)[0] == 0
    (session,) = Study(tmp_path / LATIN).sessions
    assert session.recording().parquet is not None
    assert session.recording().note == ""
    assert Study(tmp_path / LATIN).frames.df().equals(frames)


def test_a_folder_that_cannot_be_linked_to_is_told(tmp_path, run, monkeypatch):
    def refuse(*_: object) -> None:
        raise OSError(errno.EPERM, "no privilege")

    go(tmp_path, study=LATIN)
    monkeypatch.setattr(Path, "symlink_to", refuse)
    code, _, err = run("pack", tmp_path / LATIN)
    assert code == 2
    assert "st\\udcfcdy: its name has characters that the database does not take" in err


def test_bytes_that_are_no_text_are_typed_and_printed(monkeypatch):
    typed = io.TextIOWrapper(io.BytesIO(b"M\xfcller\n"), "utf-8")
    printed = io.BytesIO()
    monkeypatch.setattr(sys, "stdin", typed)
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(printed, "ascii"))
    cli._escape_foreign_text()
    print(input(), "\ud800 – é", flush=True)
    assert printed.getvalue() == b"M\\xfcller \\ud800 \\u2013 \\xe9\n"
    cli._escape_foreign_text()  # when it has been read from
