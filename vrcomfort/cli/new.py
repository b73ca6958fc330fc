"""`new` and `schema`: a commented protocol to begin with, and the schema of the project's files."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vrcomfort.cli.options import Json, Quiet
from vrcomfort.cli.terminal import answer, conclude, dialogue, warn
from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable
from vrcomfort.protocol import parse_protocol
from vrcomfort.protocol.conditions import EFFECTS
from vrcomfort.protocol.draft import BLURS, BOTH, EACH, DraftCondition, ProtocolDraft
from vrcomfort.questionnaire import find_instrument, shipped_instruments
from vrcomfort.resources import data_folder
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from pydantic import BaseModel


NO_RATING = "none"
USUAL_BREAK_S = 600.0


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(new)
    app.command()(schema)


def new(
    study: Annotated[
        Path, typer.Argument(metavar="STUDY", help="Name of the study, or of its file: lens_study.")
    ],
    title: Annotated[str | None, typer.Option(help="Title of the study.")] = None,
    compare: Annotated[
        list[str] | None,
        typer.Option(
            metavar="EFFECT",
            help="Effect of a condition, compared with none; once for each condition. "
            "With settings: vignette.restricted_deg=40; several in one: depth_of_field+vignette; "
            "both: depth of field and motion blur as crossed factors; each: as a condition each.",
        ),
    ] = None,
    scene: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME|FILE.glb", help="A shipped scene, or a .glb; once for each."),
    ] = None,
    from_: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE.glb",
            help="A scene of your own, with a side-car for its light and start, if it has none.",
        ),
    ] = None,
    participants: Annotated[
        int | None,
        typer.Option("--participants", "-n", help="Number of participants.", min=1, max=10_000),
    ] = None,
    exposure_s: Annotated[
        float | None, typer.Option(help="Length of an exposure, in s.", min=6, max=14_400)
    ] = None,
    exposure_min: Annotated[float | None, typer.Option(hidden=True, min=0.1, max=240)] = None,
    break_s: Annotated[
        float | None, typer.Option(help="Break between two exposures, in s.", min=0, max=14_400)
    ] = None,
    sessions: Annotated[
        int | None,
        typer.Option(help="Days over which exposures are distributed.", min=1, max=100),
    ] = None,
    questionnaire: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="Asked before and after each exposure; once for each. Without it: ssq.",
        ),
    ] = None,
    rating: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.toml|none", help="Question during exposure, such as fms or misc."
        ),
    ] = None,
    language: Annotated[
        list[str] | None,
        typer.Option(help="Language of the questions; once for each."),
    ] = None,
    unbalanced: Annotated[
        bool,
        typer.Option(
            "--unbalanced", help="Keep the number of participants, and let orders be unbalanced."
        ),
    ] = False,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Ask nothing at the terminal.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a commented protocol for a new study.

    In a terminal, questions are asked for what no option gives; elsewhere, and with --yes, defaults
    are taken.

    - `vrcomfort new lens_study`
    - `vrcomfort new lens_study --compare depth_of_field --scene temple -n 8 --yes`
    - `vrcomfort new tunnel --compare vignette.restricted_deg=40 --compare speed_blur --sessions 3`
    - `vrcomfort new two_days --compare each --sessions 2 -n 16 --unbalanced --yes`
    - `vrcomfort new hall_study --from hall.glb --questionnaire my_questions.toml --yes`
    """
    file = study if study.suffix == ".toml" else study.with_name(f"{study.name}.toml")
    _require_free(file)
    asks = _Asker(somebody_answers() and not yes)
    effects = [*EFFECTS, BOTH, EACH]
    compared = compare or asks.words(
        f"What is compared with no effect ({', '.join(effects)})", "depth_of_field", effects
    )
    own = [] if from_ is None else [str(from_)]
    scenes = [*own, *(scene or [])] or asks.words(
        "Scenes, with commas", "temple", _shipped_scenes()
    )
    wanted = participants or asks.number("How many participants are planned", 16)
    title = title or asks.text("What is the study called", file.stem.replace("_", " "))
    if exposure_s is None:
        exposure_s = 60 * (exposure_min or asks.number("Minutes of an exposure", 10))
    days = sessions or asks.number("Over how many days are exposures distributed", 1)
    known = sorted(shipped_instruments())
    asked = questionnaire or asks.words("Questionnaires, with commas", "ssq", known)
    rated = rating or asks.words("Question during exposure", "fms", [*known, NO_RATING])[0]
    draft = ProtocolDraft(
        name=file.stem,
        title=_line(title),
        compared=_conditions(compared),
        scenes=tuple(_beside(each, file) for each in scenes),
        participants=wanted,
        exposure_s=exposure_s,
        break_s=USUAL_BREAK_S if break_s is None else break_s,
        sessions=days,
        questionnaires=tuple((_beside(each, file), find_instrument(each)) for each in asked),
        rating=None if rated == NO_RATING else (_beside(rated, file), find_instrument(rated)),
        languages=tuple(language or asks.words("Languages, with commas", "en", ["en", "de"])),
    )
    draft = _balanced(draft, file, unbalanced=unbalanced)
    protocol = parse_protocol(draft.toml(), file=file)
    side_car = None if from_ is None else _side_car(from_)
    _write(file, protocol.toml)
    _tell_changes(draft, wanted)
    facts = {
        "file": str(file),
        "participants": draft.participants,
        "conditions": [each.name for each in protocol.conditions],
        "side_car": None if side_car is None else str(side_car),
    }
    also = "" if side_car is None else f" The side-car of the scene is {side_car}."
    sentence = f"{file} is written; look into it, then: vrcomfort check {file}{also}"
    conclude(sentence, facts, quiet=quiet, as_json=as_json)


def _tell_changes(draft: ProtocolDraft, wanted: int) -> None:
    """Warn where the draft differs from the request; `wanted` is the number of participants."""
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


def _conditions(texts: list[str]) -> tuple[DraftCondition, ...]:
    """Return the conditions that are compared with none; empty for crossed factors.

    Raises
    ------
    InputError
        If there is no such effect, two are the same, or crossed factors have conditions beside.
    """
    if BOTH in texts:
        if len(texts) > 1:
            raise InputError(f"--compare {BOTH} makes all four conditions; leave the others away")
        return ()
    texts = [each for text in texts for each in (BLURS if text == EACH else (text,))]
    found = [DraftCondition.of_text(text) for text in texts]
    names = [each.name for each in found]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"--compare gives `{name}` twice; give each condition once")
    return tuple(found)


def _beside(name: str, file: Path) -> str:
    """Return the name of something shipped, or a path as a protocol in `file` has it."""
    if Path(name).suffix not in {".toml", ".glb", ".gltf"}:
        return name
    return Path(os.path.relpath(name, file.parent)).as_posix()


def _side_car(scene: Path) -> Path | None:
    """Write the side-car of a scene that has none, with its start as it was found.

    Raises
    ------
    InputError
        If the scene cannot be read.
    """
    from vrcomfort.scene.load import load_scene
    from vrcomfort.scene.side_car import draft_side_car

    loaded = load_scene(str(scene))
    for warning in loaded.warnings:
        warn(warning)
    file = scene.with_suffix(".toml")
    if file.exists():
        return None
    _write(file, draft_side_car(loaded, scene.name))
    return file


def somebody_answers() -> bool:
    """Return whether a terminal is there to be typed into."""
    return sys.stdin.isatty()


def _line(text: str) -> str:
    """Return a text in one line, as a comment of a file can hold it."""
    return escape_unprintable(" ".join(text.split()))


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


_OWN = re.compile(r"\.(glb|gltf|toml)$|[.+]")
"""Files, and effects with settings, which are checked later."""


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

    def words(self, question: str, usual: str, known: list[str]) -> list[str]:
        """Return words; those that are neither known nor files are asked again."""
        while True:
            words = [word.strip() for word in self.text(question, usual).split(",") if word.strip()]
            wrong = [each for each in words if each not in known and not _OWN.search(each)]
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
    kind: Annotated[FileKind, typer.Argument(help="Kind of file.")],
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
