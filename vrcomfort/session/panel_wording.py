"""Finds the words of a protocol that the panel cannot draw."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.texts import LanguageTable
from vrcomfort.questionnaire import Instrument
from vrcomfort.questionnaire.instrument_file import TranslationTable
from vrcomfort.settings import KeyPath
from vrcomfort.text_layout import undrawable

MOST_NAMED = 3
"""Characters that a sentence names."""
_DRAWS = "the panel draws one letter after the other, from left to right, in one font"
_OTHERWISE = "write it in other letters"
_ALOUD = f"{_OTHERWISE}, or have it asked aloud with --respondent console or terminal"
_SHOWN = f'{_OTHERWISE}, or make a `picture` of it with text = ""'

_Text: TypeAlias = tuple[str, str, KeyPath]
"""Its name in a sentence, the text itself, and its key."""


def undrawable_wording(protocol: Protocol, *, asked_aloud: bool = False) -> Iterator[InputError]:
    """Yield texts that the panel cannot draw, of a protocol in a participant's language.

    Parameters
    ----------
    asked_aloud
        Questions do not stand on the panel: instructions and the panel's own words alone do.
    """
    groups: list[tuple[list[_Text], str]] = [(_words(protocol), _OTHERWISE)]
    groups += [([each], _SHOWN) for each in _instructions(protocol)]
    if not asked_aloud:
        groups += [(texts, _ALOUD) for texts in _questions(protocol)]
        groups += [([each], _ALOUD) for each in _free_texts(protocol)]
    for texts, remedy in groups:
        found = [each for each in texts if undrawable(each[1])]
        if found:
            yield protocol.fault(found[0][2], f"{_sentence(found)}; {_DRAWS}; {remedy}")


def _sentence(found: Sequence[_Text]) -> str:
    """Say of texts that they cannot be drawn, and name some of the characters."""
    more = f", and {len(found) - 1} more like it," if len(found) > 1 else ""
    characters = undrawable("\n".join(text for _, text, _ in found))
    named = ", ".join(characters[:MOST_NAMED])
    others = len(characters) - MOST_NAMED
    named += f" and {others} more" if others > 0 else ""
    return f"{found[0][0]}{more} cannot be drawn on the panel: {named}"


def _table(protocol: Protocol) -> tuple[str, LanguageTable]:
    """Return the participant's language, and the words that the protocol has for it."""
    language = protocol.language or "en"
    return language, protocol.text.get(language, LanguageTable())


def _words(protocol: Protocol) -> list[_Text]:
    language, table = _table(protocol)
    return [
        (f"`{key}` of the panel's words", text, ("text", language, "words", key))
        for key, text in table.words.items()
    ]


def _instructions(protocol: Protocol) -> Iterator[_Text]:
    language, table = _table(protocol)
    for index, each in enumerate(protocol.told):
        path: KeyPath = ("instructions", index, "text")
        if each.name in table.instructions:
            path = ("text", language, "instructions", each.name, "text")
        yield f"instruction `{each.name}`", each.text, path


def _free_texts(protocol: Protocol) -> Iterator[_Text]:
    language, table = _table(protocol)
    for index, each in enumerate(protocol.free_texts):
        path: KeyPath = ("free_texts", index, "text")
        if each.name in table.free_texts:
            path = ("text", language, "free_texts", each.name)
        yield f"free text `{each.name}`", table.free_texts.get(each.name, each.text), path


def _questions(protocol: Protocol) -> Iterator[list[_Text]]:
    """Yield the texts of each questionnaire and rating, without repetitions."""
    asked: dict[tuple[str, str], tuple[Instrument, KeyPath]] = {}
    for index, ask in enumerate(protocol.questionnaires):
        form = protocol.form(ask)
        where: KeyPath = ("questionnaires", index, "instrument")
        asked.setdefault((form.name, form.language), (form, where))
    for index, ratings in enumerate(protocol.ratings):
        form = protocol.rated(ratings)
        asked.setdefault((form.name, form.language), (form, ("ratings", index, "instrument")))
    for form, where in asked.values():
        yield list(_form(protocol, form, where))


def _form(protocol: Protocol, form: Instrument, asked: KeyPath) -> Iterator[_Text]:
    """Yield the texts of an instrument on the panel.

    Parameters
    ----------
    asked
        Key of the instrument's name: the place of what the protocol does not word itself.
    """
    table = protocol.text.get(form.language, LanguageTable()).instruments.get(form.name)
    worded: KeyPath = ("text", form.language, "instruments", form.name)

    def place(is_given: object, *keys: str) -> KeyPath:
        return (*worded, *keys) if is_given else asked

    given = table or TranslationTable()
    where = place(given.instruction, "instruction")
    yield f"the instruction of the {form.short}", form.instruction, where
    labels = [form.answers.labels, *(item.answers.labels for item in form.asked)]
    for label in dict.fromkeys(label for each in labels for label in each):
        yield f"an answer of the {form.short}", label, place(given.labels, "labels")
    for item in form.asked:
        where = place(item.name in given.items, "items", item.name)
        yield f"item `{item.name}` of the {form.short}", item.text, where
