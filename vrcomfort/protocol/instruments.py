"""The instruments that a protocol asks: found, and such that they can be asked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from vrcomfort.errors import InputError
from vrcomfort.protocol.asking import Ask
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.screening import screening_problems
from vrcomfort.protocol.stopping import rise_problems
from vrcomfort.questionnaire import Instrument, find_instrument
from vrcomfort.settings import KeyPath, Problem

MOST_ITEMS = 16
"""What the list of all answers has room for, on the panel in the headset."""
MOST_ANSWERS = 101
MOST_LETTERS, MOST_OF_INSTRUCTION = 200, 110
"""Of a question and of an instruction, which are then as small as can be read in a headset."""


def find_instruments(protocol: Protocol) -> tuple[dict[str, Instrument], list[Problem]]:
    """Return what the protocol calls an instrument → that instrument, and what is not found."""
    beside = protocol.file.parent if protocol.file else None
    found: dict[str, Instrument] = {}
    faults: list[Problem] = []
    for path, name in _named(protocol):
        try:
            found[name] = find_instrument(name, beside=beside)
        except InputError as error:
            faults.append(Problem(path, str(error)))
    texts: dict[str, str] = {}
    for path, name in _named(protocol):
        if name in found and texts.setdefault(found[name].name, found[name].text) != (
            found[name].text
        ):
            message = f"two instruments of this protocol are called `{found[name].name}`"
            faults.append(Problem(path, f"{message}; rename one"))
    return found, faults


def _named(protocol: Protocol) -> Iterator[tuple[KeyPath, str]]:
    for index, ask in enumerate(protocol.questionnaires):
        yield ("questionnaires", index, "instrument"), ask.instrument
    for index, ratings in enumerate(protocol.ratings):
        yield ("ratings", index, "instrument"), ratings.instrument
    for index, slider in enumerate(protocol.sliders):
        yield ("sliders", index, "instrument"), slider.instrument


def missing_wording(protocol: Protocol) -> Iterator[InputError]:
    """Yield instruments whose items have no wording in a language in which people are asked.

    Simulated participants answer them all the same.
    """
    told: list[str] = []
    for language in [protocol.language] if protocol.language else protocol.languages or [None]:
        spoken = protocol.spoken(language)
        forms = [spoken.form(ask) for ask in spoken.questionnaires]
        forms += [spoken.rated(each) for each in spoken.all_rated]
        for (path, _), form in zip(_named(protocol), forms, strict=True):
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
    """Yield what keeps the instruments that were found from being asked."""
    more = protocol.sliders or protocol.adjustments or protocol.free_texts
    if not (protocol.questionnaires or protocol.ratings or protocol.tasks or more):
        message = (
            "nothing is asked, rated or done; add [[questionnaires]], [[ratings]] or [[tasks]]"
        )
        yield Problem((), message)
    for path, name in _named(protocol):
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
            message = f"the {found.short} is rated twice during exposure, and nobody could tell"
            yield Problem(path, f"{message} the two apart; keep one")


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
