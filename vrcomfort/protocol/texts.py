"""The words that participants read, by language: those of the panel, and those of instruments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field

from vrcomfort.protocol.questions import Asked
from vrcomfort.protocol.session_steps import Instruction, InstructionWording, wording_problems
from vrcomfort.questionnaire import Instrument
from vrcomfort.questionnaire.instrument_file import TranslationTable
from vrcomfort.questionnaire.instruments import Translation
from vrcomfort.settings import KeyPath, Problem, Settings, did_you_mean, repeated

Button = Annotated[str, Field(min_length=1, max_length=30)]
Sentence = Annotated[str, Field(min_length=1, max_length=110)]


class Words(Settings):
    """All texts of the headset's panels, except those of studies and instruments."""

    back: Button = "Back"
    """Button: to the question before."""
    decline: Button = "Rather not say"
    """Button: no answer to this question."""
    stop: Button = "Stop"
    """Button: a wish to stop, which is asked once more."""
    all_correct: Button = "All correct"
    """Button: below the list of all answers."""
    review: Sentence = "These are your answers. Choose one to change it."
    """Over the list of all answers."""
    place: Sentence = "{number} of {count}. {instruction}"
    """Over a question."""
    hint: Sentence = "Click, or type {answers}, then Enter"
    """Where there is a keyboard."""
    sure: Sentence = "Do you want to stop the study?"
    """Question to participants who want to stop."""
    go_on: Button = "No, continue"
    """Button: an answer to that."""
    stop_now: Button = "Yes, stop now"
    """Button: the other."""
    rest: Button = "Rest"
    """Over a rest."""
    rest_minutes: Sentence = (
        "You may take the headset off. The study continues in {minutes} minutes."
    )
    """During a rest."""
    rest_soon: Sentence = "You may take the headset off. The study continues in less than a minute."
    """In the last minute of one."""
    rest_ready: Sentence = "You may take the headset off. Choose Continue when you are ready."
    """Of a rest that the participant may end."""
    sit_up: Sentence = "Please sit up straight and look ahead."
    """While the height of the eyes is measured."""
    stand_up: Sentence = "Please stand up straight and look ahead."
    """The same."""
    no_controller: Sentence = "No controller found. Switch one on, or ask for help."
    """Where there is nothing to point with."""
    look_twice: Sentence = "Look at an answer, look away, and look at it again"
    """Where looks choose."""
    proceed: Button = "Continue"
    """Button: below an instruction."""
    ready: Sentence = "Welcome. The study starts in a moment."
    """Until an operator starts the session."""
    paused: Sentence = "A short pause. The study continues in a moment."
    """While an operator has paused it."""
    loading: Sentence = "Loading …"
    """While a scene is loaded."""
    listen: Sentence = "Please listen to the experimenter."
    """While questions are asked aloud."""
    rest_aloud: Sentence = "Rest. You may take the headset off."
    """During a rest of which the experimenter tells the end."""
    listen_sound: Sentence = "Please listen."
    """While an instruction is heard that has nothing to see."""
    wait_experimenter: Sentence = "Please wait while the experimenter decides how to continue."
    """While the experimenter decides whether to go on."""
    say_aloud: Sentence = "Please tell the experimenter"
    """Over a question that is answered in one's own words."""


ENGLISH = Words()
GERMAN = Words(
    back="Zurück",
    decline="Keine Angabe",
    stop="Abbrechen",
    all_correct="Alles richtig",
    review="Das sind Ihre Antworten. Wählen Sie eine, um sie zu ändern.",
    place="{number} von {count}. {instruction}",
    hint="Klicken, oder die Zahl tippen, dann Enter",
    sure="Möchten Sie die Studie abbrechen?",
    go_on="Nein, weiter",
    stop_now="Ja, jetzt abbrechen",
    rest="Pause",
    rest_minutes="Sie dürfen das Headset abnehmen. Es geht in {minutes} Minuten weiter.",
    rest_soon="Sie dürfen das Headset abnehmen. Es geht in weniger als einer Minute weiter.",
    rest_ready="Sie dürfen das Headset abnehmen. Wählen Sie Weiter, sobald Sie bereit sind.",
    sit_up="Bitte setzen Sie sich aufrecht hin und blicken Sie geradeaus.",
    stand_up="Bitte stellen Sie sich aufrecht hin und blicken Sie geradeaus.",
    no_controller="Kein Controller ist zu sehen: einschalten, oder um Hilfe bitten",
    look_twice="Auf eine Antwort blicken, wegblicken, und noch einmal hinblicken",
    proceed="Weiter",
    ready="Willkommen. Es geht gleich los.",
    paused="Eine kurze Pause. Es geht gleich weiter.",
    loading="Wird geladen …",
    listen="Bitte hören Sie der Versuchsleitung zu.",
    rest_aloud="Pause. Sie dürfen das Headset abnehmen.",
    listen_sound="Bitte hören Sie zu.",
    wait_experimenter="Bitte warten Sie. Die Versuchsleitung hat etwas zu entscheiden.",
    say_aloud="Bitte sagen Sie es der Versuchsleitung",
)
WORDS: Mapping[str, Words] = {"en": ENGLISH, "de": GERMAN}
"""Languages that are shipped."""


class LanguageTable(Settings):
    """A language: `[text.fr]`. For a shipped one only the differences to it."""

    source: str = ""
    """Whose wording it is; recorded."""
    words: dict[str, Sentence] = Field(default_factory=dict)
    """Of the panel, by the keys of its words."""
    instruments: dict[str, TranslationTable] = Field(default_factory=dict)
    """Instrument → its instruction, labels and items, as in [translations] of an instrument."""
    instructions: dict[str, InstructionWording] = Field(default_factory=dict)
    """Name of an instruction → its text in this language."""
    free_texts: dict[str, Asked] = Field(default_factory=dict)
    """Name of a free text → its question in this language."""


def words_of(language: str, tables: Mapping[str, LanguageTable]) -> Words:
    """Return the panel's words in a language that `text_problems` finds nothing wrong with."""
    given = tables[language].words if language in tables else {}
    return WORDS.get(language, ENGLISH).model_copy(update=given)


def translated(
    instrument: Instrument, language: str, tables: Mapping[str, LanguageTable]
) -> Instrument:
    """Return an instrument with the words that a protocol gives it in a language."""
    table = tables.get(language)
    given = table.instruments.get(instrument.name) if table else None
    if table is None or given is None:
        return instrument
    whole = Translation(given.instruction, given.labels, given.source or table.source)
    texts = {item: worded.text for item, worded in given.items.items()}
    return instrument.with_translation(language, whole, texts)


def text_problems(
    languages: tuple[str, ...],
    tables: Mapping[str, LanguageTable],
    asked: Mapping[str, Instrument],
    instructions: tuple[Instruction, ...] = (),
    folder: Path | None = None,
) -> list[Problem]:
    """Return wordings that languages lack, and wordings of nothing.

    Parameters
    ----------
    asked
        The instruments whose language is the participant's, by their names.
    folder
        Where the files of instructions are looked for.
    """
    found: list[Problem] = []
    found += repeated(("languages",), languages)
    for index, language in enumerate(dict.fromkeys(languages)):
        path: KeyPath = ("text", language) if language in tables else ("languages", index)
        given = tables[language].words if language in tables else {}
        missing = [] if language in WORDS else [w for w in Words.model_fields if w not in given]
        if missing:
            message = f"`{language}` lacks words of the panel: {', '.join(missing)}"
            found.append(Problem(path, f"{message}; write them into [text.{language}.words]"))
        for instrument in asked.values():
            lacks = translated(instrument, language, tables).lacks(language)
            if lacks:
                message = f"the {instrument.short} lacks in `{language}`: {', '.join(lacks)}"
                table_name = f"[text.{language}.instruments.{instrument.name}]"
                found.append(Problem(path, f"{message}; write it into {table_name}"))
        wordings = tables[language].instructions if language in tables else {}
        for where, message in wording_problems(
            language, index == 0, wordings, instructions, folder
        ):
            found.append(Problem((*path, *where), message))
    for language, table in tables.items():
        found += _of_nothing(language, table, languages, asked)
    return found


def _of_nothing(
    language: str,
    table: LanguageTable,
    languages: tuple[str, ...],
    asked: Mapping[str, Instrument],
) -> list[Problem]:
    path: KeyPath = ("text", language)
    if language not in languages:
        message = f"`{language}` is not among `languages`; add it there, or remove this"
        return [Problem(path, message)]
    found = []
    for key, text in table.words.items():
        if key not in Words.model_fields:
            hint = did_you_mean(key, Words.model_fields)
            found.append(Problem((*path, "words", key), f"the panel has no `{key}`; {hint}"))
            continue
        try:
            # All that any of the panel's words is ever given: a brace beside is a mistake.
            text.format(number=1, count=1, instruction="", answers="", minutes=1)
        except (KeyError, IndexError, ValueError):
            message = f"`{key}` has braces that stand for nothing; the English has"
            usual = getattr(ENGLISH, key)
            found.append(Problem((*path, "words", key), f"{message} {usual!r}"))
    for name, given in table.instruments.items():
        here = (*path, "instruments", name)
        if name not in asked:
            hint = did_you_mean(name, asked)
            found.append(Problem(here, f"no instrument `{name}` is asked so; {hint}"))
            continue
        items = [item.name for item in asked[name].items]
        for item in given.items:
            if item not in items:
                message = f"there is no item `{item}`; {did_you_mean(item, items)}"
                found.append(Problem((*here, "items", item), message))
        labels = len(asked[name].labels)
        if given.labels and len(given.labels) != labels:
            message = f"{len(given.labels)} labels, and the {asked[name].short} has {labels}"
            found.append(Problem((*here, "labels"), f"{message}; give as many"))
    return found
