"""Draw the panel of somebody who answers by looks: ``python scripts/panel_of_looks.py OUT``."""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

from vrcomfort.protocol.texts import ENGLISH
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.respondent.panel_layout import ends_of, question_cells
from vrcomfort.respondent.panel_picture import DwellProgress, Page, Painter


def main(out: Path) -> None:
    """Write ``panel_looks.png``: the second look at a prepared answer, five eighths done."""
    ssq = shipped_instruments()["ssq"]
    item = ssq.items[0]
    cells = question_cells(item.answers, first=True)
    title = f"1 of {len(ssq.items)}. {ssq.instruction}"
    page = Page(title, item.text, cells, ends_of(item.answers), 0.0, hint=ENGLISH.look_twice)
    picture = Painter().draw(page, cells[1], DwellProgress(cells[1], 5, cells[1]))
    Image.fromarray(picture).convert("RGB").save(out / "panel_looks.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
