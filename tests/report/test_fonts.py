"""The font of the figures: every letter of the one it is made of, in the same widths."""

from pathlib import Path

import pytest
from fontTools.ttLib import TTFont
from matplotlib import get_data_path

from vrcomfort.report.canvas import FAMILY, WHOLE, canvas, load_fonts


@pytest.mark.parametrize("name", ["DejaVuSans.ttf", "DejaVuSans-Bold.ttf"])
@pytest.mark.smoke
def test_the_copy_has_every_letter_in_its_width(name):
    source = Path(get_data_path()) / "fonts" / "ttf" / name
    with TTFont(source) as whole, TTFont(load_fonts() / name) as copy:
        assert copy.getBestCmap() == whole.getBestCmap()
        assert copy["hmtx"].metrics == whole["hmtx"].metrics
        assert copy["name"].getDebugName(1) == FAMILY
        assert copy["head"].modified == whole["head"].modified, "no two PDFs would be alike"


def test_figures_embed_the_copy_and_name_the_font_that_others_have():
    with canvas("letters", 3, 2) as (figure, drawing):
        figure.text(0.5, 0.5, "Größe − ẞ", fontweight="bold")
    assert b"vrcomfortSans-Bold" in drawing.pdf()
    assert f"'{WHOLE}'" in drawing.svg
    assert FAMILY not in drawing.svg
