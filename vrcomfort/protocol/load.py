"""Loads a protocol: its file with all includes, its instruments and its tasks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from pydantic import ValidationError

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.protocol.check import folder_of, problems
from vrcomfort.protocol.condition_check import adjusted_conditions
from vrcomfort.protocol.factors import crossed, factor_problems
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import NO_TASK, written_orders
from vrcomfort.protocol.questions import Ask, rise_problems, screening_problems
from vrcomfort.protocol.texts import text_problems, translated
from vrcomfort.questionnaire import Instrument, find_instrument
from vrcomfort.resources import data_folder
from vrcomfort.settings import (
    KeyPath,
    Problem,
    did_you_mean,
    in_words,
    problems_of,
    repeated,
)
from vrcomfort.settings.include import Source
from vrcomfort.tasks import (
    OwnTask,
    TaskCode,
    TaskSettings,
    declared_settings,
    installed_task,
    own_task_file,
    read_task_code,
    run_installed_task,
)

MOST_ITEMS = 18
"""Room of the list of all answers, on the panel in the headset."""
MOST_ANSWERS = 101  # 0 to 100, a visual analogue scale
MOST_LETTERS, MOST_OF_INSTRUCTION = 200, 110
"""Of a question and of an instruction, which are then as small as can be read in a headset."""


def load_protocol(name_or_path: str | Path) -> Protocol:
    """Read a protocol: a file, or a shipped one.

    Parameters
    ----------
    name_or_path : str or Path
        A TOML file, or the name of a shipped protocol such as ``"carnegie_2015"``.

    Returns
    -------
    Protocol
        The validated protocol; ``protocol.condition("dof_on")`` is one of its conditions.

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
    """Return a protocol with the combinations of its factors' levels as conditions."""
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
    if path.exists() and not path.is_dir():
        return path  # what is no regular file is refused where it is opened
    shipped = {file.stem: file for file in data_folder("protocols").glob("*.toml")}
    if str(name_or_path) in shipped:
        return shipped[str(name_or_path)]
    if path.is_dir():
        raise InputError("this is a folder; a protocol is a TOML file", file=path)
    hint = did_you_mean(path.stem, shipped)
    raise InputError(f"there is no protocol file or shipped protocol `{name_or_path}`; {hint}")


def find_instruments(protocol: Protocol) -> tuple[dict[str, Instrument], list[Problem]]:
    """Return the instruments by their names in the protocol, and faults of missing ones."""
    beside = protocol.file.parent if protocol.file else None
    found: dict[str, Instrument] = {}
    faults: list[Problem] = []
    for path, name in _named_instruments(protocol):
        try:
            found[name] = find_instrument(name, beside=beside)
        except InputError as error:
            faults.append(Problem(path, str(error)))
    texts: dict[str, str] = {}
    for path, name in _named_instruments(protocol):
        if name in found and texts.setdefault(found[name].name, found[name].text) != (
            found[name].text
        ):
            message = f"two instruments of this protocol are called `{found[name].name}`"
            faults.append(Problem(path, f"{message}; rename one"))
    return found, faults


def _named_instruments(protocol: Protocol) -> Iterator[tuple[KeyPath, str]]:
    for index, ask in enumerate(protocol.questionnaires):
        yield ("questionnaires", index, "instrument"), ask.instrument
    for index, ratings in enumerate(protocol.ratings):
        yield ("ratings", index, "instrument"), ratings.instrument
    for index, slider in enumerate(protocol.sliders):
        yield ("sliders", index, "instrument"), slider.instrument


def missing_wording(protocol: Protocol) -> Iterator[InputError]:
    """Yield instruments with items that lack a wording in one of the study's languages.

    Simulated participants answer them all the same.
    """
    told: list[str] = []
    for language in [protocol.language] if protocol.language else protocol.languages or [None]:
        spoken = protocol.spoken(language)
        forms = [spoken.form(ask) for ask in spoken.questionnaires]
        forms += [spoken.rated(each) for each in spoken.all_rated]
        for (path, _), form in zip(_named_instruments(protocol), forms, strict=True):
            if form.unworded:
                message = _unworded(form, protocol.languages)
                if message not in told:
                    told.append(message)
                    yield protocol.fault(path, message)


def _unworded(form: Instrument, languages: tuple[str, ...]) -> str:
    names = ", ".join(form.unworded)
    table = f"[text.{form.language}.instruments.{form.name}.items]"
    also = "" if form.language in languages else f', with `languages = ["{form.language}"]`'
    return (
        f"the {form.short} has no wording in `{form.language}` for {names}: people would be asked "
        f"these names; write the questions into {table}{also}, or into an instrument file of yours"
    )


def instrument_problems(
    protocol: Protocol, instruments: Mapping[str, Instrument]
) -> Iterator[Problem]:
    """Yield faults of found instruments that cannot be asked."""
    more = protocol.sliders or protocol.adjustments or protocol.free_texts
    if not (protocol.questionnaires or protocol.ratings or protocol.tasks or more):
        message = (
            "nothing is asked, rated or done; add [[questionnaires]], [[ratings]] or [[tasks]]"
        )
        yield Problem((), message)
    for path, name in _named_instruments(protocol):
        if name in instruments:
            yield from _unaskable(path, instruments[name])
    for index, ask in enumerate(protocol.questionnaires):
        found = instruments.get(ask.instrument)
        if found and ask.language and found.in_language(ask.language) is None:
            message = f"the {found.short} has no complete wording in `{ask.language}`"
            hint = "leave `language` out, or translate it in a file of your own"
            yield Problem(("questionnaires", index, "language"), f"{message}; {hint}")
        if found and ask.compares:
            yield from _compared(("questionnaires", index), ask, found)
    yield from _of_ratings(protocol, instruments)
    yield from _of_sliders(protocol, instruments)
    whens: dict[str, set[str]] = {}
    for ask in protocol.questionnaires:
        if ask.instrument in instruments:
            whens.setdefault(ask.instrument, set()).add(ask.when)
    yield from rise_problems(protocol.stop, whens, instruments)
    at_start = {name for name, when in whens.items() if "session_start" in when}
    yield from screening_problems(protocol.screening, at_start, instruments, protocol.covariates)


def _compared(path: KeyPath, ask: Ask, instrument: Instrument) -> Iterator[Problem]:
    if ask.compares == "pair" and ask.when != "after_trial":
        message = "a pair is compared after its second exposure"
        yield Problem((*path, "when"), f'{message}; write when = "after_trial"')
    for item in instrument.asked:
        low, high, step = item.answers.low, item.answers.high, item.answers.step
        if low not in (0, 1) or high < 2 or step != 1 or (ask.compares == "pair" and high != 2):
            message = f"item {item.name} of the {instrument.short} is answered by"
            needs = "1 and 2, or 0 to 2" if ask.compares == "pair" else "1, 2, …, or 0, 1, 2, …"
            yield Problem((*path, "instrument"), f"{message} {low} to {high}; it needs {needs}")


def _unaskable(path: KeyPath, instrument: Instrument) -> Iterator[Problem]:
    if len(instrument.asked) > MOST_ITEMS:
        message = f"the {instrument.short} has {len(instrument.asked)} items"
        yield Problem(path, f"{message}; at most {MOST_ITEMS} can be asked, so divide it in two")
    if not instrument.asked:
        yield Problem(path, f"no item of the {instrument.short} is asked; leave it out")
    if len(instrument.instruction) > MOST_OF_INSTRUCTION:
        message = f"the instruction of the {instrument.short} has {len(instrument.instruction)}"
        yield Problem(path, f"{message} letters; give one of at most {MOST_OF_INSTRUCTION}")
    for item in instrument.asked:
        if len(item.text) > MOST_LETTERS:
            message = f"item {item.name} of the {instrument.short} has {len(item.text)} letters"
            yield Problem(path, f"{message}; a question that is read has at most {MOST_LETTERS}")
        if item.answers.count > MOST_ANSWERS:
            message = f"item {item.name} of the {instrument.short} has {item.answers.count} answers"
            yield Problem(path, f"{message}; give an `asked_step` with at most {MOST_ANSWERS}")
        elif any(not isinstance(answer, int) or answer < 0 for answer in item.answers.asked):
            message = f"item {item.name} of the {instrument.short} has answers that cannot be typed"
            yield Problem(path, f"{message}; let `low` and `asked_step` be whole, and 0 or more")


def _of_sliders(protocol: Protocol, instruments: Mapping[str, Instrument]) -> Iterator[Problem]:
    called = [
        found.name for each in protocol.all_rated if (found := instruments.get(each.instrument))
    ]
    for index, slider in enumerate(protocol.sliders):
        path: KeyPath = ("sliders", index, "instrument")
        found = instruments.get(slider.instrument)
        if found is None:
            continue
        if len(found.asked) != 1:
            message = f"the {found.short} has {len(found.asked)} items; a slider is one question"
            yield Problem(path, f"{message}: ask it in [[questionnaires]]")
        elif called.count(found.name) > 1:
            message = f"the {found.short} is rated twice during exposure, and the ratings could"
            yield Problem(path, f"{message} not be told apart; keep one")


def _of_ratings(protocol: Protocol, instruments: Mapping[str, Instrument]) -> Iterator[Problem]:
    for index, ratings in enumerate(protocol.ratings):
        path: KeyPath = ("ratings", index)
        found = instruments.get(ratings.instrument)
        if found is None:
            continue
        if len(found.asked) != 1:
            message = f"the {found.short} has {len(found.asked)} items; a rating is one question"
            yield Problem((*path, "instrument"), f"{message}: ask it in [[questionnaires]]")
            continue
        answers = found.asked[0].answers
        if ratings.stop_at is not None and not answers.low < ratings.stop_at <= answers.high:
            message = f"the {found.short} goes from {answers.low} to {answers.high}"
            hint = f"choose a stop rule above {answers.low}, and at most {answers.high}"
            yield Problem((*path, "stop_at"), f"{message}; {hint}")


def find_tasks(protocol: Protocol) -> tuple[dict[str, TaskSettings], list[Problem]]:
    """Return name → settings of each task, and the faults. No task file is run."""
    found: dict[str, TaskSettings] = {}
    faults = list(repeated(("tasks",), [each.name for each in protocol.tasks]))
    for index, task in enumerate(protocol.tasks):
        if task.name == NO_TASK:
            message = f"`{NO_TASK}` says that there is no task; give this one another name"
            faults.append(Problem(("tasks", index, "name"), message))
        found[task.name] = task
        if isinstance(task, OwnTask) and installed_task(task.kind) is None:
            try:
                model = declared_settings(own_task_file(_folder(protocol), task.kind))
            except InputError as error:
                faults.append(Problem(("tasks", index, "kind"), str(error)))
                continue
            if model is not None:
                faults += _taken(model, task, index)[1]
    return found, faults + list(_unknown_tasks(protocol))


def _taken(
    model: type[TaskSettings], task: OwnTask, index: int
) -> tuple[TaskSettings | None, list[Problem]]:
    """Return an entry of [[tasks]] as a model of its settings, or its faults."""
    try:
        return model.model_validate(task.model_dump(), strict=True), []
    except ValidationError as error:
        found = problems_of(model, error)
    return None, [
        Problem(("tasks", index, *each.path), each.message, each.missing) for each in found
    ]


def task_code_of(protocol: Protocol) -> TaskCode:
    """Read the Python files of a protocol's own tasks, and all that these import; run none.

    Tasks of installed packages are not among them.

    Raises
    ------
    InputError
        If one cannot be read, or lies outside of the protocol's folder.
    """
    own = (task.kind for task in protocol.tasks if isinstance(task, OwnTask))
    return read_task_code(_folder(protocol), (k for k in own if installed_task(k) is None))


def with_task_code(protocol: Protocol, code: TaskCode) -> Protocol:
    """Return the protocol with its own tasks ready to start: this runs their Python files.

    Only what is about to hold a session calls it, after the consent to `code`. Until then the
    settings of an own task are an `OwnTask`, whatever keys they have.

    Raises
    ------
    InputError
        If a file cannot be run, or does not take the settings.
    """
    ready, faults = dict(protocol._tasks), []
    ran = code.hashes
    for index, task in enumerate(protocol.tasks):
        if not isinstance(task, OwnTask):
            continue
        try:
            if (installed := installed_task(task.kind)) is not None:
                model, ran[task.kind] = run_installed_task(installed)
            else:
                model = code.run(task.kind)
        except InputError as error:
            faults.append(Problem(("tasks", index, "kind"), str(error)))
            continue
        settings, wrong = _taken(model, task, index)
        faults += wrong
        if settings is not None:
            ready[task.name] = settings
    if faults:
        raise protocol.first_fault(faults)
    prepared = protocol.model_copy()
    prepared._tasks, prepared._task_code = ready, ran
    return prepared


def _folder(protocol: Protocol) -> Path:
    return protocol.file.parent if protocol.file else Path()


def _unknown_tasks(protocol: Protocol) -> Iterator[Problem]:
    known = [task.name for task in protocol.tasks]
    for path, name in _named_tasks(protocol):
        if name not in (None, NO_TASK, *known):
            hint = did_you_mean(str(name), known) if known else "add it to [[tasks]]"
            yield Problem(path, f"there is no task `{name}`; {hint}")


def _named_tasks(protocol: Protocol) -> Iterator[tuple[KeyPath, str | None]]:
    yield ("task",), protocol.task
    if not protocol.factors:
        for index, condition in enumerate(protocol.conditions):
            yield ("conditions", index, "task"), condition.task
    for index, factor in enumerate(protocol.factors):
        for number, level in enumerate(factor.levels):
            yield ("factors", index, "levels", number, "task"), level.task
    for index, sequence in enumerate(protocol.order.sequences):
        for session, trials in enumerate(sequence.sessions):
            for number, trial in enumerate(trials):
                path = ("order", "sequences", index, "sessions", session, number, "task")
                yield path, trial.task
    for index, part, order in written_orders(protocol.parts):
        for number, trial in enumerate(order.trials):
            yield ("parts", index, "orders", part, "trials", number, "task"), trial.task
    for index, practice in enumerate(protocol.practice):
        for number, trial in enumerate(practice.trials):
            yield ("practice", index, "trials", number, "task"), trial.task
