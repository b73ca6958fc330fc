"""Write docs/commands.md from the commands, their arguments and their options."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer
from typer.main import get_command

from vrcomfort.cli.app import GROUPS, app

PAGE = Path(__file__).parent.parent / "docs" / "commands.md"


def page() -> str:
    """Return the page of all commands: what each does, its arguments and options."""
    commands: Any = get_command(app)
    parts = ["# Commands\n\n`vrcomfort COMMAND --help` shows the same in a terminal.\n"]
    for title, group in GROUPS.items():
        parts.append(f"## {title}\n")
        parts += [
            _command(name, commands.get_command(None, name))
            for name, listed in group.items()
            if not listed.hidden
        ]
    return "\n".join(parts)


def _command(name: str, command: Any) -> str:
    context = typer.Context(command)
    shown = [each.get_help_record(context) for each in command.params if not each.hidden]
    rows = [f"| `{names}` | {text} |".replace("\n", " ") for names, text in filter(None, shown)]
    table = "\n".join(["| | |", "|---|---|", *(row for row in rows)])
    return f"### vrcomfort {name}\n\n{command.help.strip()}\n\n{table}\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
