"""`new` and `schema`: a commented protocol to begin with, and the schema of the project's files."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vrcomfort.cli.terminal import answer, console, dialogue, warn
from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable
from vrcomfort.protocol import parse_protocol
from vrcomfort.protocol.draft import ProtocolDraft
from vrcomfort.resources import data_folder
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from pydantic import BaseModel


class ComparedKind(StrEnum):
    """Effects that can be compared with no blur."""

    DEPTH_OF_FIELD = "depth_of_field"
    MOTION_BLUR = "motion_blur"
    BOTH = "both"
    EACH = "each"


class RatingKind(StrEnum):
    """The question during exposure."""

    FMS = "fms"
    MISC = "misc"
    NONE = "none"


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(new)
    app.command()(schema)


def new(
    study: Annotated[
        Path, typer.Argument(metavar="STUDY", help="Name of the study, or of its file: lens_study.")
    ],
    title: Annotated[str | None, typer.Option(help="In words.")] = None,
    compare: Annotated[
        ComparedKind | None,
        typer.Option(help="With no blur; both: crossed; each: three conditions."),
    ] = None,
    scene: Annotated[
        list[str] | None, typer.Option(help="A shipped scene, or a .glb file; once for each.")
    ] = None,
    participants: Annotated[
        int | None, typer.Option(help="How many are planned.", min=1, max=10_000)
    ] = None,
    exposure_min: Annotated[
        float | None, typer.Option(help="Length of an exposure.", min=0.1, max=240)
    ] = None,
    sessions: Annotated[
        int | None, typer.Option(help="Over which exposures are dealt.", min=1, max=100)
    ] = None,
    rating: Annotated[
        RatingKind | None, typer.Option(help="Asked again and again during exposure.")
    ] = None,
    language: Annotated[
        list[str] | None, typer.Option(help="In which participants are asked; once for each.")
    ] = None,
    unbalanced: Annotated[
        bool, typer.Option(help="Keep the number of participants, and let orders be unbalanced.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="Ask nothing: what is not given is as usual.")
    ] = False,
) -> None:
    """Write a commented protocol for a new study.

    What no option gives is asked, in a terminal; elsewhere, or with --yes, it is as usual.

    - `vrcomfort new lens_study`
    - `vrcomfort new lens_study --compare depth_of_field --scene temple --participants 8 --yes`
    - `vrcomfort new two_days --compare each --sessions 2 --participants 16 --unbalanced --yes`
    """
    file = study if study.suffix == ".toml" else study.with_name(f"{study.name}.toml")
    _require_free(file)
    asks = _Asker(somebody_answers() and not yes)
    compared = compare or ComparedKind(
        asks.choice("What is compared with no blur", list(ComparedKind), "depth_of_field")
    )
    scenes = tuple(scene or asks.words("Scenes, with commas", "temple", _shipped_scenes()))
    wanted = participants or asks.number("How many participants are planned", 16)
    draft = ProtocolDraft(
        name=file.stem,
        title=_line(title or asks.text("What is the study called", file.stem.replace("_", " "))),
        compared=compared.value,
        scenes=scenes,
        participants=wanted,
        exposure_s=60 * (exposure_min or asks.number("Minutes of an exposure", 10)),
        sessions=sessions or asks.number("Over how many sessions are exposures dealt", 1),
        rating=_rating(rating or asks.choice("Rated during exposure", list(RatingKind), "fms")),
        languages=tuple(language or asks.words("Languages, with commas", "en", ["en", "de"])),
    )
    draft = _balanced(draft, file, unbalanced=unbalanced)
    protocol = parse_protocol(draft.toml(), file=file)
    _write(file, protocol.toml)
    if draft.rating and not draft.has_time_for_ratings:
        needed_s = sum(draft.rating_times_s)
        warn(
            f"exposures of {draft.exposure_s:g} s have no time for ratings, which take "
            f"{needed_s:g} s; none is asked during them"
        )
    if draft.participants != wanted:
        orders = f"{wanted} participants would not balance the orders"
        warn(f"{orders}; it plans {draft.participants} (--unbalanced keeps {wanted})")
    if not draft.divides:
        pairs = f"{draft.exposures} exposures do not divide over {draft.sessions} sessions"
        warn(f"{pairs}; each session shows all of them")
    console().print(f"{file} is written; look into it, then: vrcomfort check {file}")


def somebody_answers() -> bool:
    """Return whether a terminal is there to be typed into."""
    return sys.stdin.isatty()


def _line(text: str) -> str:
    """Return a text in one line, as a comment of a file can hold it."""
    return escape_unprintable(" ".join(text.split()))


def _rating(kind: str) -> str:
    return "" if kind == RatingKind.NONE else str(RatingKind(kind).value)


def _require_free(file: Path) -> None:
    if not re.fullmatch(r"[A-Za-z0-9_-]+", file.stem):
        message = f"a study cannot be called {file.stem!r}; use letters, digits, - and _"
        raise InputError(message)
    if file.exists():
        raise InputError("this file is there already; choose another name", file=file)
    if not file.parent.is_dir():
        raise InputError("there is no such folder; make it first", file=file.parent)


def _shipped_scenes() -> list[str]:
    return sorted(path.stem for path in data_folder("scenes").glob("*.glb"))


def _balanced(draft: ProtocolDraft, file: Path, *, unbalanced: bool) -> ProtocolDraft:
    """Return the draft with the next number of participants that fills all orders alike.

    With `unbalanced`, the number stays, and the protocol says that it is meant.
    """
    from vrcomfort.design import build_design
    from vrcomfort.design.audit import cannot_balance

    design = build_design(parse_protocol(draft.toml(), file=file))
    people = draft.participants
    if unbalanced:
        return replace(draft, unbalanced=cannot_balance(design, people) is not None)
    while cannot_balance(design, people):
        people += 1
    return replace(draft, participants=people)


def _write(file: Path, text: str) -> None:
    try:
        with file.open("x", encoding="utf-8") as new_file:
            new_file.write(text)
    except FileExistsError as error:
        raise InputError("this file is there already; choose another name", file=file) from error


class _Asker:
    """Asks for values that no option gives, or takes the usual ones.

    Parameters
    ----------
    asks
        A person is there to answer.
    """

    def __init__(self, asks: bool) -> None:
        self._asks = asks

    def text(self, question: str, usual: str) -> str:
        """Return the answer; an empty line takes the usual one."""
        if not self._asks:
            return usual
        try:
            return input(f"{question}? [{usual}] ").strip() or usual
        except EOFError:
            self._asks = False
            return usual

    def choice(self, question: str, known: list[str], usual: str) -> str:
        """Return one of the known words."""
        return self.words(f"{question} ({', '.join(known)})", usual, known)[0]

    def words(self, question: str, usual: str, known: list[str]) -> list[str]:
        """Return words; those that are neither known nor files are asked again."""
        while True:
            words = [word.strip() for word in self.text(question, usual).split(",") if word.strip()]
            wrong = [each for each in words if each not in known and not each.endswith(".glb")]
            if words and not wrong:
                return words
            hint = did_you_mean(wrong[0], known) if wrong else "write at least one"
            dialogue().print(f"There is no {wrong[0]!r}: {hint}" if wrong else hint)

    def number(self, question: str, usual: int) -> int:
        """Return a whole number from 1 up."""
        while True:
            text = self.text(question, str(usual))
            if text.isascii() and text.isdecimal() and int(text) > 0:
                return int(text)
            dialogue().print("A whole number, please.")


class FileKind(StrEnum):
    """Which file."""

    PROTOCOL = "protocol"
    PLAN = "plan"
    SIDE_CAR = "side-car"


def schema(
    kind: Annotated[FileKind, typer.Argument(help="Which of the project's TOML files.")],
) -> None:
    """Print the JSON Schema of protocols, analysis plans, or scenes' side-cars.

    - `vrcomfort schema protocol > protocol.schema.json`
    - `vrcomfort schema plan > plan.schema.json`
    """
    from vrcomfort.settings.schema import json_schema

    answer(json_schema(_model(kind)))


def _model(kind: FileKind) -> type[BaseModel]:
    from vrcomfort.protocol import Protocol
    from vrcomfort.report.plan_files import AnalysisPlan
    from vrcomfort.scene.side_car import SideCar

    models: dict[FileKind, type[BaseModel]] = {
        FileKind.PROTOCOL: Protocol,
        FileKind.PLAN: AnalysisPlan,
        FileKind.SIDE_CAR: SideCar,
    }
    return models[kind]
