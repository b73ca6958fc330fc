"""What participants are told at a moment: words, a picture, a sound, each a file or a text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import KeyPath, Problem, Settings, Word, did_you_mean, repeated

When = Literal["session_start", "before_practice", "before_trial", "after_trial", "session_end"]
Number = Annotated[int, Field(ge=1, le=1000)]
Telling = Annotated[str, Field(max_length=2000)]
MediaFile = Annotated[str, Field(max_length=200)]
MEDIA = ("picture", "sound")
"""Keys that name files."""


class InstructionWording(Settings):
    """An instruction in another language: `[text.de.instructions.welcome]`."""

    text: Telling = ""
    """Words on the panel; `""` where the `picture` says them."""
    picture: MediaFile = ""
    """PNG or JPEG file; without it, that of the usual language."""
    sound: MediaFile = ""
    """WAV file."""


class Instruction(Settings):
    """Something that participants are told, one at a time, before they go on."""

    name: Word
    """As `events.csv` has it."""
    when: When
    """`session_start` and `session_end`: before and after all questions; `before_trial` and
    `after_trial`: before their questions; `before_practice`: before each block of practice."""
    text: Telling = ""
    """Words on the panel, in the usual language."""
    picture: MediaFile = ""
    """PNG or JPEG file on the panel, relative to the protocol file."""
    sound: MediaFile = ""
    """WAV file that is played once."""
    show_text: Literal["always", "without_sound"] = "always"
    """`without_sound`: the text stands in for a sound that cannot be played."""
    sessions: tuple[Number, ...] = ()
    """Numbers of the sessions in which it is told; without it, all."""
    trials: tuple[Number, ...] = ()
    """Numbers, within the session, of the trials that it belongs to; without it, all."""
    min_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    """The participant cannot go on sooner, nor before the sound is over."""
    max_s: Annotated[float, Field(gt=0, le=3600)] | None = None
    """It goes on by itself then; without it, when the participant goes on."""

    def is_due(self, when: str, session: int, trial: int | None) -> bool:
        """Return whether it is told at a moment."""
        here = self.when == when and (not self.sessions or session in self.sessions)
        return here and (not self.trials or trial in self.trials)

    def worded(self, wording: InstructionWording | None) -> Instruction:
        """Return it in a language that has a wording of its own."""
        if wording is None:
            return self
        picture = wording.picture or self.picture
        return self.model_copy(
            update={"text": wording.text, "picture": picture, "sound": wording.sound}
        )

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield key and path of the files that it needs."""
        for key in MEDIA:
            if path := getattr(self, key):
                yield key, path


def instruction_problems(
    instructions: tuple[Instruction, ...], folder: Path | None
) -> Iterator[Problem]:
    """Yield what is wrong with instructions.

    Parameters
    ----------
    folder
        Where their files are looked for; None: nowhere.
    """
    yield from repeated(("instructions",), [each.name for each in instructions])
    for index, each in enumerate(instructions):
        path: KeyPath = ("instructions", index)
        yield from _missing_files(path, each.files(), folder)
        if not (each.text or each.picture or each.sound):
            message = f"`{each.name}` tells nothing; give it a `text`, a `picture` or a `sound`"
            yield Problem((*path, "name"), message)
        if each.max_s is not None and each.max_s < each.min_s:
            yield Problem((*path, "max_s"), "`max_s` is less than `min_s`; make it longer")
        if each.trials and each.when.startswith("session"):
            message = f'`trials` does nothing with when = "{each.when}"; remove it or change that'
            yield Problem((*path, "trials"), message)
        if each.show_text == "without_sound" and not (each.text and each.sound):
            message = "`show_text` needs a `text` and a `sound`; remove it or add them"
            yield Problem((*path, "show_text"), message)


def _missing_files(
    path: KeyPath, files: Iterable[tuple[str, str]], folder: Path | None
) -> Iterator[Problem]:
    for key, name in files:
        if folder is not None and not (folder / name).is_file():
            yield Problem((*path, key), f"there is no {key} file {folder / name}")


def wording_problems(
    language: str,
    usual: bool,
    given: Mapping[str, InstructionWording],
    instructions: tuple[Instruction, ...],
    folder: Path | None,
) -> Iterator[tuple[KeyPath, str]]:
    """Yield where, below the language's table, and what is wrong with instructions in it.

    Parameters
    ----------
    usual
        Whether it is the language of `[[instructions]]` itself.
    """
    by_name = {each.name: each for each in instructions}
    for name, wording in given.items():
        here: KeyPath = ("instructions", name)
        if name not in by_name:
            yield here, f"there is no instruction `{name}`; {did_you_mean(name, by_name)}"
            continue
        if usual:
            yield here, f"`{language}` is the usual language: its words stand in [[instructions]]"
        files = Instruction.files(by_name[name].worded(wording))
        for problem in _missing_files(here, files, folder):
            yield problem.path, problem.message
    for each in instructions if not usual else ():
        wording = given.get(each.name, InstructionWording())
        lacks = [
            key for key in ("text", "sound") if getattr(each, key) and not getattr(wording, key)
        ]
        if wording.picture and "text" in wording.model_fields_set:
            lacks = [key for key in lacks if key != "text"]
        if lacks:
            what = f"instruction `{each.name}` lacks its {' and its '.join(lacks)} in `{language}`"
            yield (), f"{what}; write it into [text.{language}.instructions.{each.name}]"
