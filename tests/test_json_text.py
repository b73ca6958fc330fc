"""JSON of files from elsewhere is read in one place, and damage is told in words of its own."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import pytest

import vrcomfort
from vrcomfort.errors import InputError
from vrcomfort.importing.source import Reading
from vrcomfort.importing.text_files import read_json_table
from vrcomfort.json_text import parse_json
from vrcomfort.scene.load import load_scene

PARSER = re.compile(r"Expecting|delimiter|Extra data|Unterminated|Invalid|char \d|property name")
"""Words of Python's parser, which say nothing to whom a file belongs."""
OURS = {
    "json_text.py": "the reader",
    "records/json_file.py": "indents what it wrote itself",
    "tradeoff/measure.py": "rows of its own store of measurements",
    "console/wire.py": "messages between two processes of a session",
    "console/server.py": "the first of those; and messages of a page, refused in a sentence",
}
"""Who else parses JSON, and why it is nobody's file."""


def refused(text: str, **more) -> InputError:
    with pytest.raises(InputError) as caught:
        parse_json(text, Path("a.json"), **more)
    return caught.value


@pytest.mark.parametrize(
    ("text", "said", "line", "column"),
    [
        ("", "there is nothing in it", 1, 1),
        (" \n", "there is nothing in it", 2, 1),
        ('{"a": 1', "it ends before it is whole", 1, 8),
        ('{"a": [1, 2,\n\n', "it ends before it is whole", 3, 1),
        ('{"a": 1\n "b": 2}', "a comma or a closing bracket is missing before this place", 2, 2),
        ('{"a" 1}', "a colon is missing before this place", 1, 6),
        ("{a: 1}", "a name in double quotes is needed here", 1, 2),
        ('{"a": P01}', "a value is needed here; a text stands in double quotes", 1, 7),
        ('{"a": 1}\n}', "the JSON is over before this place", 2, 1),
        ('{"a": "x}', "the text that begins here has no closing quote", 1, 7),
        ('{"a": "x\n}', "a text is not closed before the end of its line", 1, 9),
        ('{"a": "C:\\data"}', "this backslash means nothing here", 1, 10),
        ('{\n"a": "\\ud800"}', "`a` has half a character", 2, 6),
    ],
)
def test_damage_is_told_with_its_place_and_what_to_do(text, said, line, column):
    error = refused(text, what="manifest")
    assert said in error.message
    assert error.message.endswith(": this manifest is damaged; restore it")
    assert (error.file, error.line, error.column) == (Path("a.json"), line, column)


@pytest.mark.parametrize(
    ("text", "said"), [("[" * 100_000, "nested too deep"), ("9" * 5000, "a number is too long")]
)
def test_what_no_program_can_hold_is_told_too(text, said):
    assert said in refused(text).message


def test_no_damage_is_told_in_the_words_of_the_parser():
    lists = {"a": [1, -2.5e3, True, None, "x\\n\u00e9"], "b": {"c": "", "d": []}}
    whole = json.dumps(lists, indent=1)
    instead = ("", ",", ":", '"', "\\", "}", "]", "\n", "x")
    cuts = (whole[:at] + put + whole[at + 1 :] for at in range(len(whole)) for put in instead)
    faults = [fault for fault in map(fault_of, cuts) if fault]
    assert len({fault.message for fault in faults}) >= 8  # of the many ways
    for fault in faults:
        assert not PARSER.search(str(fault))
        assert fault.line is not None
        assert fault.column is not None


def fault_of(text: str) -> InputError | None:
    try:
        parse_json(text, Path("a.json"))
    except InputError as error:
        return error
    return None


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ('{"a": 1}\n\n{"a": 2}\n{"a" 3}\n', 4, "a colon is missing"),
        ('{\n"a": 1,\n"b" 2}', 3, "a colon is missing"),
        ("a;b\n1;2", 1, "a value is needed here"),
    ],
)
def test_the_damaged_line_of_many_records_is_told(tmp_path, text, line, said):
    file = tmp_path / "log.json"
    file.write_text(text, "utf-8")
    with pytest.raises(InputError, match=said) as caught:
        read_json_table(file, Reading())
    assert caught.value.line == line
    assert caught.value.message.endswith("mend it there, or export it again")


def test_a_record_may_hold_a_separator_of_lines(tmp_path):
    file = tmp_path / "log.json"
    file.write_text('{"a": "x\u2028y"}\n{"a": "z"}\n', "utf-8")
    assert [row[0] for row in read_json_table(file, Reading()).rows] == ["a", "x y", "z"]


def test_a_damaged_scene_is_told_with_its_line(tmp_path):
    file = tmp_path / "a.gltf"
    file.write_text('{\n"asset": {"version": "2.0"}\n"nodes": []}', "utf-8")
    with pytest.raises(InputError, match=r"a comma .* this glTF is damaged") as caught:
        load_scene(file)
    assert (caught.value.line, caught.value.column) == (3, 1)


def test_a_text_of_more_values_than_a_file_may_have_is_refused_before_it_is_parsed():
    assert parse_json('[{"a": 1}, {"b": 2}]', Path("a.json"), most_marks=4) == [{"a": 1}, {"b": 2}]
    with pytest.raises(InputError, match="this manifest has more than 4 values"):
        parse_json('[{"a": 1}, {"b": 2}, "no end', Path("a.json"), what="manifest", most_marks=4)


def test_no_other_place_parses_json():
    root = Path(vrcomfort.__file__).parent
    texts = {file: file.read_text("utf-8") for file in root.rglob("*.py")}
    found = {
        file.relative_to(root).as_posix()
        for file, text in texts.items()
        if "json" in text  # as all of the parsers are called, or what has them
        for node in ast.walk(ast.parse(text))
        if _parses(node)
    }
    assert found == set(OURS)


def _parses(node: ast.AST) -> bool:
    """Whether a node takes one of the parsers, by any name."""
    if isinstance(node, ast.ImportFrom):
        return (
            bool(node.module)
            and node.module.startswith("json")
            and any("load" in each.name or "Decode" in each.name for each in node.names)
        )
    if isinstance(node, ast.Attribute):
        of_json = isinstance(node.value, ast.Name) and node.value.id == "json"
        parsers = ("model_validate_json", "validate_json", "from_json", "read_json", "raw_decode")
        return (of_json and node.attr in ("load", "loads", "JSONDecoder")) or node.attr in parsers
    names = node.names if isinstance(node, ast.Import) else []
    return any(each.name in ("orjson", "ujson") for each in names)
