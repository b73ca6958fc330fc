"""Options of all commands: one name, one meaning; old names work and are not shown."""

import json
import re

import pytest
import typer
from typer.testing import CliRunner

from vrcomfort.cli.app import OLD_OPTIONS, app

GROUP = typer.main.get_command(app)
COMMANDS = {
    name: command
    for name in GROUP.list_commands(None)
    if not (command := GROUP.get_command(None, name)).hidden
}
ANSWERS_ALONE = {"status", "design", "list", "schema", "docs", "score"}
"""Commands that print the answer asked for and nothing beside it: there is nothing to silence."""
WITHOUT_JSON = {
    "run": "a dialogue with people",
    "schema": "JSON in any case",
    "docs": "opens a page",
}
SHORT = {"--participants": "-n", "--quiet": "-q", "--yes": "-y", "--help": "-h"}
BASES = {
    "--participants": "a number, or for `power` a range of them",
    "--pose": "six numbers as text",
}


def options():
    """Yield command, name and declaration of every option that help shows."""
    for name, command in COMMANDS.items():
        for each in command.params:
            if each.param_type_name == "option" and not each.hidden:
                for spelt in each.opts:
                    yield name, spelt, each


def kind(option) -> str:
    """Return whether an option is a switch, a number or a text."""
    if option.is_flag:
        return "switch"
    return "number" if re.match("<?(int|float)", option.bare_type()) else "text"


def test_an_option_of_one_name_takes_the_same_kind_of_value_everywhere():
    kinds: dict[str, dict[str, str]] = {}
    for command, name, option in options():
        kinds.setdefault(name, {})[command] = kind(option)
    assert len(kinds) > 60
    different = {
        name: found
        for name, found in kinds.items()
        if len(set(found.values())) > 1 and name not in {*BASES, "-n"}
    }
    assert different == {}


def test_short_names_belong_to_one_option():
    for command, name, option in options():
        if not name.startswith("--"):
            (long,) = [each for each in option.opts if each.startswith("--")]
            assert SHORT.get(long) == name, (command, long, name)
    for command, name, option in options():
        if name in SHORT:
            assert SHORT[name] in option.opts, (command, name)


@pytest.mark.parametrize("name", COMMANDS)
def test_output_can_be_silenced_and_read_by_programs(name):
    spelt = {each for command, each, _ in options() if command == name}
    assert ("--quiet" in spelt) == (name not in ANSWERS_ALONE)
    assert ("--json" in spelt) == (name not in WITHOUT_JSON)


def test_lengths_have_their_unit_in_the_name():
    for command, name, option in options():
        if kind(option) == "number" and "length" in (option.help or "").lower():
            assert name.endswith(("-s", "-mm", "-m")), (command, name)


@pytest.mark.parametrize(
    ("command", "old", "new"),
    [(name, *pair) for name, pairs in OLD_OPTIONS.items() for pair in pairs.items()],
)
def test_old_names_lead_to_options_that_there_are_and_are_not_shown(command, old, new):
    spelt = {
        each for each in COMMANDS[command].params for each in (*each.opts, *each.secondary_opts)
    }
    assert new in spelt
    assert old not in spelt
    shown = CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200"}).output
    assert f" {old} " not in shown


def test_old_names_go_on_working(tmp_path):
    file, study = tmp_path / "s.toml", tmp_path / "study"
    new = ["new", file, "--exposure-min=1", "--rating", "none", "--participants", 2, "--yes"]
    made = CliRunner().invoke(app, [*map(str, new), "--json"])
    assert made.exit_code == 0, made.output
    assert json.loads(made.stdout)["conditions"] == ["off", "depth_of_field"]
    assert "exposure_s = 60.0" in file.read_text("utf-8")
    simulate = ["simulate", file, "-n", 2, "--no-frames", "--out", study, "--json"]
    done = CliRunner().invoke(app, [*map(str, simulate)])
    assert done.exit_code == 0, done.output
    sessions = json.loads(done.stdout)["sessions"]
    assert [each["status"] for each in sessions] == ["completed", "completed"]
    note = CliRunner().invoke(app, ["note", str(study), "P01", "tall", "--json"])
    assert json.loads(note.stdout) == {"participant": "P01", "note": "tall"}


def test_piped_tables_keep_a_row_in_a_line(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    listed = CliRunner().invoke(app, ["list", "instruments"]).stdout.splitlines()
    assert any(
        line.split()[:1] == ["mssq_child"] and line.rstrip().endswith("before the age of 12")
        for line in listed
    )
