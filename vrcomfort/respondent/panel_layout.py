"""The layout of the panel: rectangles with a meaning, in pixels of the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.questionnaire import Answer, Answers, Instrument
from vrcomfort.text_layout import composed, width_px

SIZE_PX = 1024, 768
"""On a panel 45° wide a degree has 23 pixels: no text is smaller than 1.4°, which leaves 21 pixels
of a headset with 15 pixels per degree. What is too long stands in lines, or is shortened."""

MARGIN_PX, GAP_PX = 40, 16
ANSWER_TOP_PX, ANSWER_BOTTOM_PX = 372, 540
FOOT_TOP_PX, FOOT_BOTTOM_PX = 648, 728
HINT_PX = 614
LIST_TOP_PX, LIST_HEIGHT_PX, LIST_ROWS = 112, 512, 8
SMALL_PX = 32
"""The smallest text: 1.4°."""
MANY = 5
"""Scales with more steps than this become a slider."""
NUMBERED = 21
"""A slider with more steps has no numbers: a line with two ends."""


class Act(Enum):
    """Actions of a chosen cell."""

    ANSWER = "answer"
    BACK = "back"
    DECLINE = "rather not say"
    STOP = "stop"
    WITHDRAW = "withdraw"
    CONFIRM = "confirm"
    CORRECT = "correct"


@dataclass(frozen=True)
class Cell:
    """A rectangle that can be chosen.

    Parameters
    ----------
    box
        (left, top, right, bottom), from the top left corner.
    text
        What is written in it.
    act, value
        What it does: the answer for ANSWER, the item's index for CORRECT.
    """

    box: tuple[int, int, int, int]
    text: str
    act: Act
    value: int = 0

    @property
    def center(self) -> tuple[float, float]:
        """Return the middle as fractions (right, down) of the picture."""
        left, top, right, bottom = self.box
        return (left + right) / 2 / SIZE_PX[0], (top + bottom) / 2 / SIZE_PX[1]


def cell_at(cells: Sequence[Cell], point: tuple[float, float] | None) -> Cell | None:
    """Return the cell at the fractions (right, down) of the picture."""
    if point is None:
        return None
    x, y = point[0] * SIZE_PX[0], point[1] * SIZE_PX[1]
    return next((each for each in cells if _contains(each.box, x, y)), None)


def answer_cells(cells: Sequence[Cell]) -> list[Cell]:
    """Return the cells that answer."""
    return [each for each in cells if each.act is Act.ANSWER]


def question_cells(answers: Answers, *, first: bool, words: Words = ENGLISH) -> list[Cell]:
    """Return the cells of a question: its answers, and those at the foot."""
    foot = [] if first else [(words.back, Act.BACK)]
    foot += [(words.decline, Act.DECLINE), (words.stop, Act.STOP)]
    return _answers(answers) + _row(foot, FOOT_TOP_PX, FOOT_BOTTOM_PX)


def ends_of(answers: Answers) -> tuple[str, str] | None:
    """Return the names of the two ends where the answers stand there as numbers."""
    if not answers.labels or _stand_named(answers):
        return None
    return answers.labels[0], answers.labels[-1]


def review_cells(
    instrument: Instrument, answers: Sequence[int | None], words: Words = ENGLISH
) -> list[Cell]:
    """Return the cells of the list of all answers: each opens its question again."""
    columns = 1 if len(answers) <= LIST_ROWS else 2
    rows_each = max(LIST_ROWS, -(-len(answers) // columns))
    rows = [
        _list_cell(columns, rows_each, index, item.text, _named(item.answers, answer))
        for index, (item, answer) in enumerate(zip(instrument.items, answers, strict=True))
    ]
    foot = [(words.all_correct, Act.CONFIRM), (words.stop, Act.STOP)]
    return rows + _row(foot, FOOT_TOP_PX, FOOT_BOTTOM_PX)


def rest_cells(words: Words = ENGLISH) -> list[Cell]:
    """Return the cells of a rest."""
    return _row([(words.stop, Act.STOP)], FOOT_TOP_PX, FOOT_BOTTOM_PX)


def instruction_cells(words: Words = ENGLISH, *, ready: bool) -> list[Cell]:
    """Return the cells below an instruction: to go on, once the participant may, and to stop."""
    foot = [(words.stop, Act.STOP)] + ([(words.proceed, Act.CONFIRM)] if ready else [])
    return _row(foot, FOOT_TOP_PX, FOOT_BOTTOM_PX)


def stop_cells(words: Words = ENGLISH) -> list[Cell]:
    """Return the cells of the confirmation of a stop; the button that asked is no answer to it."""
    choices = [(words.go_on, Act.BACK), (words.stop_now, Act.WITHDRAW)]
    return _row(choices, ANSWER_TOP_PX, ANSWER_BOTTOM_PX)


def _stand_named(answers: Answers) -> bool:
    return answers.named and len(answers.asked) <= MANY


def _answers(answers: Answers) -> list[Cell]:
    steps = [int(answer) for answer in answers.asked]
    many = len(steps) > MANY
    texts = list(answers.labels) if _stand_named(answers) else [str(step) for step in steps]
    boxes = _columns(len(steps), ANSWER_TOP_PX, ANSWER_BOTTOM_PX, gap_px=0 if many else GAP_PX)
    if many:
        texts = _ticks(texts, boxes[0][2] - boxes[0][0])
    return [
        Cell(box, text, Act.ANSWER, step)
        for box, text, step in zip(boxes, texts, steps, strict=True)
    ]


def _row(entries: Sequence[tuple[str, Act]], top: int, bottom: int) -> list[Cell]:
    boxes = _columns(len(entries), top, bottom, gap_px=GAP_PX)
    return [Cell(box, text, act) for box, (text, act) in zip(boxes, entries, strict=True)]


def _columns(count: int, top: int, bottom: int, *, gap_px: int) -> list[tuple[int, int, int, int]]:
    width = (SIZE_PX[0] - 2 * MARGIN_PX - (count - 1) * gap_px) / count
    lefts = [MARGIN_PX + index * (width + gap_px) for index in range(count)]
    return [(round(left), top, round(left + width), bottom) for left in lefts]


def _list_cell(columns: int, rows: int, index: int, question: str, answer: str) -> Cell:
    column, row = divmod(index, rows)
    left, _, right, _ = _columns(columns, 0, 0, gap_px=GAP_PX)[column]
    step_px = LIST_HEIGHT_PX // rows
    top = LIST_TOP_PX + row * step_px
    text = _in_list(question, index + 1, answer, right - left - 8)
    return Cell((left, top, right, top + step_px - 6), text, Act.CORRECT, index)


def _ticks(texts: Sequence[str], cell_px: int) -> list[str]:
    """Return a slider's tick numbers: all, every n-th, or none, as there is room."""
    last = len(texts) - 1
    if last >= NUMBERED:
        return [""] * len(texts)
    widest_px = max(width_px(text, SMALL_PX) for text in texts)
    every = next(
        (n for n in range(1, last) if last % n == 0 and widest_px + 4 <= n * cell_px), last
    )
    return [text if index % every == 0 else "" for index, text in enumerate(texts)]


def _in_list(question: str, number: int, answer: str, room_px: float) -> str:
    """Return an answer for the list; of a long question the first words and the last ones."""
    question = composed(question)  # so that no letter is cut off from its mark
    words = question.split()
    ways = [f"{question}: {answer}"]
    ways += [
        f"{number}. {' '.join(words[:first])} … {' '.join(words[len(words) - last :])}: {answer}"
        for kept in range(len(words) - 1, 1, -1)
        for last in (kept // 2,)
        for first in (kept - last,)
    ]
    letters = (f"{number}. {question[:n].rstrip()}…: {answer}" for n in range(len(question), 0, -1))
    return next(
        (way for way in (*ways, *letters) if width_px(way, SMALL_PX) <= room_px),
        f"{number}: {answer}",
    )


def _named(answers: Answers, answer: Answer | None) -> str:
    if answer is None:
        return "–"
    named = answers.named and len(answers.labels) > 2
    return answers.labels[answers.asked.index(answer)] if named else str(answer)


def _contains(box: tuple[int, int, int, int], x: float, y: float) -> bool:
    left, top, right, bottom = box
    return left <= x < right and top <= y < bottom
