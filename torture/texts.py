"""Hostile texts by every way in: the session goes on, `verify` is clean, and nothing of them runs.

What a way in refuses is refused in one sentence. What it takes goes into a report, whose page is
opened in a browser and whose R script is run, where there are such.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
from openpyxl import Workbook
from openpyxl.utils.exceptions import IllegalCharacterError
from rich.console import Console

from torture import commands, resumed
from torture.case import OTHER, TRACEBACK, Result, Rig
from torture.damaged import command
from torture.mutate import Rng, pick
from torture.session import Ended
from torture.worker import named, workers
from vrcomfort.console.server import read_command
from vrcomfort.errors import InputError
from vrcomfort.operator_interface import Command, NoOperator, OperatorStep
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.resources import data_folder
from vrcomfort.respondent import Form, Heard, SimulatedRespondent, TerminalRespondent
from vrcomfort.respondent.base import Written
from vrcomfort.scene.load import load_scene
from vrcomfort.session import (
    NoPictures,
    SessionSettings,
    StillHeadset,
    VirtualClock,
    open_enrolment,
)
from vrcomfort.session import run as run_session
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.settings import toml_value

WHO = "P01"
CASE_S, RUN_S = 240.0, 120.0
CANARY = "ran"
"""A file that appears where a text is run by a shell or by R; and the title of a page."""

RAN = f"document.title='{CANARY}'"
PIECES = (
    "a\ud800b", "\ud83d\ude00", os.fsdecode(b"M\xfcller"), "a\0b", "a\r\nb\x85c\u2028d\x0be\x1ef",
    "\x1b[31mred\x07\x7f", "\x1b]0;title\x07", 'a,"b";\t=1+1', "\u202eabc", "\u200b", "\u3164",
    "日本語 مرحبا 👩‍🔬", "NUL", "con.csv", "../../../etc/passwd", "%s%n{0}{{7*7}}", "$\\frac{$",
    "\\g<1>", "\\u0000", "\\", "'", '"', "`", "NA", "nan", "-1", "1e999", "\ufeff", "\ufffe",
    "é" * 300, "x" * 20_000, "word " * 3000, "[bold]x[/bold]", "[/]", '"""', "]]>", "--><!--",
    f"<script>{RAN}</script>", f"<img src=x onerror={RAN}>", f"<svg onload={RAN}>",
    f"\"'></style></svg><script>{RAN}</script>", f'" onmouseover="{RAN}', f"javascript:{RAN}",
    f"$(touch {CANARY})", f"`touch {CANARY}`", f"; touch {CANARY} #", f"| touch {CANARY}",
    f"=cmd|' /C touch {CANARY}'!A0", "+1", "-x", "@SUM(A1)", "=HYPERLINK(1)",
    f'"); file.create("{CANARY}"); ("', f"'); system('touch {CANARY}'); ('",
    f"`file.create('{CANARY}')`", f"I(file.create('{CANARY}'))", "'; DROP TABLE frames; --",
)  # fmt: skip
BREAKING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
FORBIDDEN = {"script", "img", "iframe", "object", "embed", "base", "form", "link"}
SSQ = shipped_instruments()["ssq"]


def torture(rig: Rig) -> Result:
    """Send texts in by all ways in turn."""
    count = rig.count(100 * len(WAYS), 2 * len(WAYS))
    limits: dict[str, Any] = {"name": _name_of, "gigabytes": 0, "case_s": CASE_S}
    with workers("torture.texts", rig.place("texts"), **limits) as pool:
        outcomes = list(rig.all("texts", count, pool.run, limit_s=rig.count(900, 45)))
    taken = sum(each.detail == "taken" for each in outcomes)
    how = (
        f"Texts (markup, formulas, commands of shells and of R, halves of characters, control "
        f"characters, 20,000 letters, and what is put together from them) by {', '.join(WAYS)} in "
        f"turn. {taken} were taken, the others refused in a sentence. What is written is one row a "
        "line without control characters, `verify` is clean, the report's page has only its own "
        "elements, its tables begin no formula; each text once in R"
        f"{'' if _r() else ' (not here)'} and in a browser{'' if _browser() else ' (not here)'}, "
        "where nothing of it runs."
    )
    return Result("texts", outcomes, how, count)


def _name_of(number: int) -> str:
    return list(WAYS)[number % len(WAYS)]


@cache
def _r() -> str | None:
    return shutil.which("Rscript")


@cache
def _browser() -> str | None:
    names = (os.environ.get("CHROME", ""), "chromium", "chromium-browser", "google-chrome")
    return next((found for name in names if name and (found := shutil.which(name))), None)


def text_of(index: int, rng: Rng) -> str:
    """Return a hostile text: the known ones, and then what is put together from them."""
    if index < len(PIECES):
        return PIECES[index]
    return "".join(pick(rng, PIECES) for _ in range(int(rng.integers(2, 5))))[:30_000]


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Send a text in, and look at everything that it became."""
    commands.import_all()
    way, index = _name_of(number), number // len(WAYS)
    text = text_of(index, np.random.default_rng([seed if index >= len(PIECES) else 0, index]))
    place = folder / "case"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    runs = index % len(WAYS) == number % len(WAYS)
    name = f"{way}: {text[:60]!r}"
    with named(name):
        ended, _ = commands.in_child(place, partial(_send, WAYS[way], text, runs=runs))
    fault, detail = ended.fault({0, 2}, several=True)
    if ended.code == 1 and fault != TRACEBACK:
        fault, detail = OTHER, ended.said[-400:]
    return {"name": name, "fault": fault, "detail": detail or ("" if ended.code else "taken")}


def _send(way: Callable[[Path, str], Ended], text: str, *, runs: bool) -> Ended:
    """Send a text in; say 1 and why where anything is wrong with what it became."""
    place = Path.cwd()
    ended = way(place, text)
    found = [f"said {ended.said!r}"] if BREAKING.search(ended.said) else []
    studies = [file.parent for file in place.rglob("dataset_description.json")]
    for study in studies:
        found += [f"{each}" for each in _not_clean(study)]
        out = place / "report"
        figures = "svg" if runs else "none"
        told = command(["report", str(study), "--out", str(out), "--figures", figures, "--quiet"])
        if told.code == 0:
            found += _not_inert(out, runs=runs)
        elif told.code != 2 or "error: " not in told.said:
            found.append(f"report: {told.said[-300:]}")
    found += [f"{file} was made" for file in place.rglob(CANARY)]
    return Ended(1, "; ".join(found)) if found else ended


def _not_clean(study: Path) -> Iterator[str]:
    told = command(["verify", str(study)])
    if told.code:
        yield f"verify: {told.code} {told.said[-300:]}"
    for file in study.rglob("*"):
        if file.suffix == ".json":
            json.loads(file.read_bytes().decode())
        if file.suffix == ".csv" and BREAKING.search(file.read_bytes().decode()):
            yield f"{file.name} has control characters"
        if file.suffix == ".csv":
            content = file.read_bytes().decode()
            if len(list(csv.reader(io.StringIO(content, newline="")))) != content.count("\n"):
                yield f"{file.name} has a row of several lines"


class _Elements(HTMLParser):
    def __init__(self, page: str) -> None:
        super().__init__()
        self.wrong: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Look at an element."""
        names = [name for name, _ in attrs if name.startswith("on")]
        links = [value for _, value in attrs if (value or "").strip().startswith("javascript")]
        self.wrong += [f"<{tag}>"] if tag in FORBIDDEN or names or links else []


def _not_inert(out: Path, *, runs: bool) -> Iterator[str]:
    own = f"<script>{(data_folder('analysis') / 'report' / 'page.js').read_text('utf-8')}</script>"
    before, there, after = (out / "index.html").read_text("utf-8").partition(own)
    yield from _Elements(before + after).wrong if there else ("the page's own script is not there",)
    for file in out.rglob("*.csv"):
        for row in csv.reader(io.StringIO(file.read_bytes().decode(), newline="")):
            for cell in row:
                formula = cell.startswith(("=", "@", "\t", "\r"))
                if formula or (cell.startswith(("+", "-")) and not _is_number(cell)):
                    yield f"{file.name}: the cell {cell[:40]!r} is a formula"
    script = out / "reproduce.R"
    if runs and _r() and script.exists():
        done = _run([_r(), "--vanilla", str(script)], out)
        if done.returncode:
            yield f"R: {done.stdout[-200:]} {done.stderr[-300:]}"
    if runs and _browser():
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
        more = ["--virtual-time-budget=2000", "--dump-dom", f"--user-data-dir={out / 'profile'}"]
        page = (out / "index.html").as_uri()
        done = _run([_browser(), *options, *more, "--enable-logging=stderr", page], out)
        if f"<title>{CANARY}</title>" in done.stdout or "</html>" not in done.stdout:
            yield f"browser: {done.stdout[:200]}"
        if "Content Security Policy" in done.stderr:
            yield "browser: the page's policy had to stop something"


def _run(words: list[Any], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words, cwd=folder, capture_output=True, text=True, check=False, timeout=RUN_S,
        errors="replace",
    )  # fmt: skip


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _protocol(place: Path, change: Callable[[str], str] = str) -> Path:
    """Write the small study's protocol; return its file."""
    shutil.copy(resumed.STUDY.with_name("room.gltf"), place)
    file = place / "protocol.toml"
    content = change(resumed.STUDY.read_text("utf-8"))
    file.write_bytes(content.encode("utf-8", "surrogatepass"))
    return file


def _session(place: Path, respondent: Any = None, operators: Any = None) -> Ended:
    """Run a session to its end."""
    file = place / "protocol.toml"
    try:
        known = load_protocol(file if file.exists() else _protocol(place))
        person = respondent or SimulatedRespondent(known.simulation, participant=WHO, seed=0)
        with open_enrolment(
            known, WHO, study=place / "study", respondent="simulated", resume=False
        ) as enrolment:
            settings = SessionSettings(
                respondent=person,
                headset_for=lambda *_: StillHeadset(resumed.RATE_HZ),
                load_scene=cache(load_scene),
                renderer=NoPictures(),
                clock=VirtualClock(),
                operators=OperatorControl(operators or NoOperator()),
            )
            outcome = run_session(enrolment, settings)
    except InputError as error:
        return Ended(2, f"error: {error}")
    return Ended(0 if outcome.status in {"completed", "enrolled"} else 1, str(outcome))


class _Page(NoOperator):
    """Sends a text as the note, and the name of an action, of the console's page."""

    def __init__(self, text: str) -> None:
        self._text, self._step, self._left = text, 0, 12

    def begin(self, step: OperatorStep) -> None:
        """Take note of the step."""
        self._step = step.number

    def next_command(self) -> Command | None:  # type: ignore[override]
        """Return what the page's message says; None where it is refused."""
        self._left -= 1
        if self._left < 0:
            return None
        action = "note" if self._left % 3 else self._text
        content = {"id": "1", "action": action, "step": self._step, "text": self._text}
        entered = read_command(json.dumps(content))
        return entered if isinstance(entered, Command) else None


def console(place: Path, text: str) -> Ended:
    """Enter notes on the page while a session runs."""
    return _session(place, operators=_Page(text))


class _Types(SimulatedRespondent):
    """An experimenter who types a text where an answer in own words is asked, and elsewhere."""

    def __init__(self, text: str, settings: Any) -> None:
        super().__init__(settings, participant=WHO, seed=0)
        self._text = text

    def _terminal(self, *lines: str) -> TerminalRespondent:
        typed = "".join(f"{line}\n" for line in lines).encode("utf-8", "surrogatepass")
        stream = io.TextIOWrapper(io.BytesIO(typed), "utf-8", errors="backslashreplace")

        def read_line(_: str) -> str:
            line = stream.readline()
            if not line:
                raise EOFError
            return line.rstrip("\n")

        return TerminalRespondent(
            Console(file=io.StringIO()), read_line=read_line, waiting_line=lambda: None
        )

    def write(self, question: str) -> Written:
        """Type it."""
        return self._terminal(self._text, "").write(question)

    def ask(self, form: Form, heard: Heard) -> None:
        """Type it in place of the first number, and then what is asked for."""
        self._terminal(self._text, *["1", ""] * 40).ask(form, heard)


def terminal(place: Path, text: str) -> Ended:
    """Type lines."""
    known = load_protocol(_protocol(place))
    return _session(place, respondent=_Types(text, known.simulation))


def argument(place: Path, text: str) -> Ended:
    """Give words of the command line: notes, reasons, titles, names of files."""
    text = text.replace("\0", "\\0")  # the system has no such argument
    ended = _session(place)
    taken = 0
    for words in (
        ["note", "study", WHO, "--", text],
        ["exclude", "study", WHO, f"--reason={text}"],
        ["undo-exclusion", "study", WHO, f"--reason={text}"],
        ["new", "mine", f"--title={text}", "--yes"],
        ["note", "study", "--", text, "why"],
        ["verify", "--", text],
        ["report", "--", text],
        ["check", "--", text],
        ["score", "--instrument", text, "study"],
    ):
        found = command(words)
        taken += not found.code
        if found.code and "error: " not in found.said:
            return Ended(1, f"{words[0]}: {found.said[-300:]}")
        if BREAKING.search(found.said):
            return Ended(1, f"{words[0]} said {found.said[-300:]!r}")
    return ended if taken else Ended(2, "error: none was taken")


def toml(place: Path, text: str) -> Ended:
    """Write titles, labels and instructions of a protocol."""
    value = toml_value(text)
    _protocol(
        place,
        lambda known: (
            known.replace(
                'title = "A session that is interrupted and goes on"',
                f"title = {value}\ncitation = {value}",
            )
            .replace('name = "plain"\n', f'name = "plain"\nlabel = {value}\n', 1)
            .replace('text = "Look around."', f"text = {value}")
            .replace('text = "What did you notice?"', f"text = {value}")
        ),
    )
    return _session(place)


def _lab(text: str) -> list[list[str]]:
    """Return a lab's table with a text in headings, names and cells."""
    rows = [["participant", "condition", text, *(item.name for item in SSQ.items)]]
    for who in range(6):
        for place, condition in enumerate([text, "b"]):
            answers = [str((who + place * 2 + number) % 4) for number, _ in enumerate(SSQ.items)]
            rows.append([text if who == 0 else f"P{who}", condition, text, *answers])
    return rows


def _import(file: Path) -> Ended:
    place = file.parent
    ended = command(["import", str(file), "--suggest", "--out", "map.toml"])
    if ended.code:
        return ended
    answered = (place / "map.toml").read_text("utf-8").replace('answer = ""', 'answer = "yes"')
    (place / "map.toml").write_text(answered, "utf-8")
    return command(["import", str(file), "--mapping", "map.toml", "--out", "study"])


def csv_table(place: Path, text: str) -> Ended:
    """Write cells of a CSV file."""
    stream = io.StringIO(newline="")
    csv.writer(stream).writerows(_lab(text))
    file = place / "lab.csv"
    file.write_bytes(stream.getvalue().encode("utf-8", "surrogatepass"))
    return _import(file)


def workbook(place: Path, text: str) -> Ended:
    """Write cells of a workbook; what XML does not have is written as Excel does: `_x0000_`."""
    text = re.sub("[\x00-\x08\x0b-\x1f\ud800-\udfff\ufffe]", lambda c: f"_x{ord(c[0]):04X}_", text)
    book = Workbook()
    for number, row in enumerate(_lab(text), start=1):
        for column, cell in enumerate(row, start=1):
            said = book.worksheets[0].cell(number, column)
            try:
                said.value = cell
            except IllegalCharacterError:
                said.value = "x"
            said.data_type = "s"
    book.save(place / "lab.xlsx")
    return _import(place / "lab.xlsx")


def json_table(place: Path, text: str) -> Ended:
    """Write names and values of JSON."""
    heading, *rows = _lab(text)
    records = [dict(zip(heading, row, strict=True)) for row in rows]
    (place / "lab.json").write_text(json.dumps(records), "utf-8")
    return _import(place / "lab.json")


def file_name(place: Path, text: str) -> Ended:
    """Name a CSV file so."""
    name = re.sub("[/\0]", "_", text).encode("utf-8", "surrogatepass")[:200]
    file = place / f"{os.fsdecode(name)}.csv"
    with file.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream).writerows(_lab("a"))
    return _import(file)


WAYS: Mapping[str, Callable[[Path, str], Ended]] = {
    "console": console,
    "terminal": terminal,
    "argument": argument,
    "TOML": toml,
    "CSV": csv_table,
    "xlsx": workbook,
    "JSON": json_table,
    "file names": file_name,
}
