"""Finds, reads and checks protocol files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from vrcomfort.errors import InputError
from vrcomfort.protocol.check import folder_of, problems
from vrcomfort.protocol.condition_check import adjusted_conditions
from vrcomfort.protocol.factors import crossed, factor_problems
from vrcomfort.protocol.instruments import find_instruments, instrument_problems
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.tasks import find_tasks
from vrcomfort.protocol.texts import text_problems, translated
from vrcomfort.questionnaire import Instrument
from vrcomfort.resources import data_folder
from vrcomfort.settings import Problem, in_words, read_text
from vrcomfort.settings.include import Source
from vrcomfort.settings.reading import did_you_mean
from vrcomfort.tasks import TaskSettings


def load_protocol(name_or_path: str | Path) -> Protocol:
    """Read a protocol: a file, or the name of a shipped one such as ``carnegie_2015``.

    Raises
    ------
    InputError
        If the file is missing or not TOML, or a key or value is wrong, with line and column.
    """
    file = _find(name_or_path)
    text = read_text(file, "protocol")
    return parse_protocol(text, file=file)


def parse_protocol(text: str, *, file: Path | None = None) -> Protocol:
    """Return the protocol written in `text`; `file` is where relative scene files are looked for.

    Raises
    ------
    InputError
        As `load_protocol`.
    """
    source = Source(text, file, "protocol")
    protocol = _with_crossed_factors(source.parse(Protocol), source)
    protocol._source, protocol._file = source, file
    instruments, found = find_instruments(protocol)
    tasks, faults = find_tasks(protocol)
    found += faults
    found += problems(protocol)
    found += instrument_problems(protocol, instruments)
    found += text_problems(
        protocol.languages,
        protocol.text,
        _asked(protocol, instruments),
        protocol.instructions,
        folder_of(protocol),
    )
    if found:
        raise source.first_problem(found)
    return _by_name(protocol, instruments, tasks)


def _with_crossed_factors(protocol: Protocol, source: Source) -> Protocol:
    """Return a protocol whose conditions are the combinations of its factors' levels."""
    if not protocol.factors:
        return protocol
    found = list(factor_problems(protocol.factors))
    if protocol.conditions:
        message = "conditions are written down and crossed from [[factors]]; keep one of the two"
        found.append(Problem(("conditions",), message))
    if not found:
        try:
            return protocol.model_copy(update={"conditions": crossed(protocol.factors)})
        except ValidationError as error:
            message = f"these levels cannot be combined: {in_words(error.errors()[0])}"
            found.append(Problem(("factors",), message))
    raise source.first_problem(found)


def _asked(protocol: Protocol, instruments: Mapping[str, Instrument]) -> dict[str, Instrument]:
    """Return name → instrument of those that are asked in the participant's language."""
    called = [ask.instrument for ask in protocol.questionnaires if ask.language is None]
    called += [rated.instrument for rated in protocol.all_rated]
    return {instruments[c].name: instruments[c] for c in called if c in instruments}


def _by_name(
    protocol: Protocol, instruments: Mapping[str, Instrument], tasks: Mapping[str, TaskSettings]
) -> Protocol:
    """Return a protocol that calls its instruments by their names, wherever they were found."""
    asks = [
        ask.model_copy(update={"instrument": instruments[ask.instrument].name})
        for ask in protocol.questionnaires
    ]
    changes: dict[str, object] = {"questionnaires": tuple(asks)}
    rises = tuple(
        each.model_copy(update={"instrument": instruments[each.instrument].name})
        for each in protocol.stop.score_rise
    )
    changes["stop"] = protocol.stop.model_copy(update={"score_rise": rises})
    changes["screening"] = tuple(
        each.model_copy(update={"instrument": instruments[each.instrument].name})
        if each.instrument
        else each
        for each in protocol.screening
    )
    for key in ("ratings", "sliders"):
        changes[key] = tuple(
            each.model_copy(update={"instrument": instruments[each.instrument].name})
            for each in getattr(protocol, key)
        )
    named = protocol.model_copy(update=changes)
    named._instruments = {}
    for each in instruments.values():
        worded = each
        for language in protocol.languages:
            worded = translated(worded, language, protocol.text)
        named._instruments[each.name] = worded
    named._tasks = dict(tasks)
    named._adjustments = {
        condition.name: each
        for each in protocol.adjustments
        for condition in adjusted_conditions(protocol, each)
    }
    return named


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.is_file():
        return path
    shipped = {file.stem: file for file in data_folder("protocols").glob("*.toml")}
    if str(name_or_path) in shipped:
        return shipped[str(name_or_path)]
    if path.is_dir():
        raise InputError("this is a folder; a protocol is a TOML file", file=path)
    hint = did_you_mean(path.stem, shipped)
    raise InputError(f"there is no protocol file or shipped protocol `{name_or_path}`; {hint}")
