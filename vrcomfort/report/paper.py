"""Methods and results as plain text, to be edited into a paper."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

from vrcomfort.plurals import counted_doing

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from vrcomfort.report.analyses import MethodsParagraph, Sentence
    from vrcomfort.report.flow import FlowStage

FILE = "paper.txt"
WIDTH = 100


def paper_text(
    flow: Sequence[FlowStage],
    paragraphs: Iterable[MethodsParagraph],
    answers: Iterable[Sentence],
    references: Iterable[str],
    software: str,
) -> str:
    """Return methods, results and references in paragraphs of plain text.

    Parameters
    ----------
    answers
        Those of the primary outcome first.
    software
        A sentence on the program that computed them.
    """
    parts = [
        "METHODS",
        *(f"{each.title}. {each.text}" for each in paragraphs),
        software,
        "RESULTS",
        " ".join(_flow(flow)),
        *(each.text for each in answers),
        "REFERENCES",
        *references,
    ]
    return "\n\n".join(fill(part, WIDTH, break_long_words=False) for part in parts) + "\n"


def _flow(flow: Sequence[FlowStage]) -> Iterator[str]:
    """Yield a sentence on each stage."""
    for stage in flow:
        were = counted_doing(stage.n, "participants", "were")
        said = {"Completed": f"{stage.n} completed the study"}.get(
            stage.stage, f"{were} {stage.stage.lower()}"
        )
        losses = "; ".join(f"{loss.n} {loss.reason}" for loss in stage.left)
        yield f"{said} (not in the next stage: {losses})." if losses else f"{said}."
