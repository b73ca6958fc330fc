"""Questions that are answered in one's own words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import KeyPath, Problem, Settings, Word, did_you_mean

Asked = Annotated[str, Field(min_length=1, max_length=300)]


class FreeText(Settings):
    """A question that is answered in one's own words, which an experimenter types."""

    name: Word
    """As ``texts.csv`` has it."""
    text: Asked
    """What is asked, in the usual language."""
    when: Literal["session_start", "before_trial", "after_trial", "session_end"]
    """After the questionnaires of that moment; `before_trial` and `after_trial`: of every
    exposure."""


def free_text_problems(
    questions: tuple[FreeText, ...],
    languages: tuple[str, ...],
    wordings: Mapping[str, Mapping[str, str]],
) -> Iterator[Problem]:
    """Yield what asks nothing, what lacks a wording, and wordings of nothing.

    Parameters
    ----------
    languages
        In which participants are asked, the usual one first.
    wordings
        Language → name → what is asked in it.
    """
    names = [each.name for each in questions]
    for index, each in enumerate(questions):
        if not each.text.strip():
            path: KeyPath = ("free_texts", index, "text")
            yield Problem(path, f"`{each.name}` asks nothing but blanks; write the question")
    for language in languages[1:]:
        for index, name in enumerate(names):
            if name not in wordings.get(language, {}):
                message = f"`{name}` is not worded in `{language}`"
                path = ("free_texts", index, "text")
                yield Problem(path, f"{message}; write it into [text.{language}.free_texts]")
    for language, given in wordings.items():
        for name in given:
            if name not in names:
                hint = did_you_mean(name, names) if names else "remove it"
                message = f"there is no free text `{name}`; {hint}"
                yield Problem(("text", language, "free_texts", name), message)
