"""`list` and `docs`: the shipped scenes, protocols and instruments, and the documentation."""

from __future__ import annotations

import tomllib
import webbrowser
from collections.abc import Callable
from inspect import getdoc
from typing import Annotated, Literal, get_args

import typer
from rich.table import Table

from vrcomfort.cli.options import Json
from vrcomfort.cli.terminal import answer, console
from vrcomfort.errors import InputError
from vrcomfort.installed import installed
from vrcomfort.protocol.conditions import EFFECTS, EffectTables
from vrcomfort.questionnaire.library import ENTRY_POINTS as INSTRUMENTS
from vrcomfort.resources import Folder, data_folder, site_folder
from vrcomfort.settings import did_you_mean
from vrcomfort.tasks.kinds import SHIPPED
from vrcomfort.tasks.own_code import ENTRY_POINTS as TASKS

Kind = Literal["effects", "instruments", "plans", "protocols", "scenes", "tasks"]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("list")(list_shipped)
    app.command()(docs)


def list_shipped(
    kind: Annotated[Kind, typer.Argument(help="Kind of things to list.")],
    json: Json = False,
) -> None:
    """List the shipped scenes, instruments, protocols, effects, tasks or plans.

    Effects, instruments and tasks of installed packages are among them.

    - `vrcomfort list protocols`
    """
    found = dict(sorted(_LISTS[kind]().items()))
    if json:
        answer(found)
        return
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for name, title in found.items():
        table.add_row(name, title)
    console(wrap=True).print(table)


def _effects() -> dict[str, str]:
    tables = {name: EffectTables.model_fields[name].annotation for name in EFFECTS}
    return {name: _summary(get_args(each)[0]) for name, each in tables.items()}


def _tasks() -> dict[str, str]:
    found = {name: _summary(each) for name, each in SHIPPED.items()}
    return found | _installed(TASKS)


def _installed(group: str) -> dict[str, str]:
    return {each.name: f"{each.value} (installed)" for each in installed(group)}


def _summary(documented: type) -> str:
    return (getdoc(documented) or "").partition("\n")[0]


def _titles(folder: Folder, group: str = "") -> Callable[[], dict[str, str]]:
    """Return a function that gives name → title of the TOML files of a folder."""
    return lambda: (
        {
            file.stem: tomllib.loads(file.read_text("utf-8")).get("title", "")
            for file in data_folder(folder).glob("*.toml")
        }
        | _installed(group)
    )


_LISTS: dict[Kind, Callable[[], dict[str, str]]] = {
    "effects": _effects,
    "instruments": _titles("instruments", INSTRUMENTS),
    "plans": _titles("analysis"),
    "protocols": _titles("protocols"),
    "scenes": _titles("scenes"),
    "tasks": _tasks,
}


def docs(
    page: Annotated[
        str, typer.Argument(metavar="[PAGE]", help="Page to open, such as import.")
    ] = "index",
) -> None:
    """Open the documentation, which needs no network.

    Prints the page's address, and opens it where there is a browser.

    - `vrcomfort docs`
    - `vrcomfort docs tutorial`
    """
    site = site_folder()
    file = site / f"{page.removeprefix('docs/').removesuffix('.md')}.html"
    if not file.is_file():
        pages = [each.stem for each in site.glob("*.html")]
        raise InputError(f"there is no page {page!r}; {did_you_mean(page, pages)}")
    typer.echo(file.as_uri())
    webbrowser.open(file.as_uri())
