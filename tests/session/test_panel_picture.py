"""How a panel looks: its cells and its pointer, and where a ray meets it."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from vrcomfort.geometry import Pose, Quad, yaw_pitch_roll
from vrcomfort.headset import inputs
from vrcomfort.headset.inputs import pointer_picture, pointer_quad
from vrcomfort.questionnaire import Answers, Instrument, shipped_instruments
from vrcomfort.respondent.panel_layout import (
    ANSWER_TOP_PX,
    SIZE_PX,
    SMALL_PX,
    Act,
    Cell,
    ends_of,
    question_cells,
    review_cells,
)
from vrcomfort.respondent.panel_picture import (
    FRAME_PX,
    LOOKED,
    DwellProgress,
    Page,
    Painter,
    Picture,
)
from vrcomfort.session.rehearsal import aim_at
from vrcomfort.text_layout import TextCanvas

SSQ, FMS = shipped_instruments()["ssq"], shipped_instruments()["fms"]


@pytest.mark.parametrize("instrument", [SSQ, FMS], ids=lambda each: each.name)
def test_cells_lie_on_the_panel_and_do_not_overlap(instrument: Instrument) -> None:
    answers = [instrument.low] * len(instrument.items)
    for cells in (
        question_cells(instrument.answers, first=False),
        review_cells(instrument, answers),
    ):
        covered = np.zeros(SIZE_PX[::-1], dtype=int)
        for cell in cells:
            left, top, right, bottom = cell.box
            assert 0 <= left < right <= SIZE_PX[0]
            assert 0 <= top < bottom <= SIZE_PX[1]
            covered[top:bottom, left:right] += 1
        assert covered.max() == 1


def test_a_cell_knows_its_middle() -> None:
    cell = Cell((0, 0, SIZE_PX[0], SIZE_PX[1] // 2), "", Act.ANSWER)
    assert cell.center == (0.5, 0.25)


def test_what_a_look_has_prepared_has_a_frame_inside_its_cell() -> None:
    cells = question_cells(SSQ.answers, first=True)
    left, top, right, bottom = cells[1].box
    expected = np.zeros(SIZE_PX[::-1], dtype=bool)
    expected[top : bottom + 1, left : right + 1] = True
    expected[top + FRAME_PX : bottom + 1 - FRAME_PX, left + FRAME_PX : right + 1 - FRAME_PX] = False
    drawn = Painter().draw(Page("", "Nausea", cells), None, DwellProgress(prepared=cells[1]))
    assert ((drawn == LOOKED).all(axis=2) == expected).all()


@pytest.mark.smoke
def test_pointing_changes_the_pointed_cell_and_nothing_else():
    cells = question_cells(FMS.answers, first=True)
    page = Page("", FMS.instruction, cells, chosen=2)
    painter = Painter()
    plain = painter.draw(page, None)
    assert plain.shape == (SIZE_PX[1], SIZE_PX[0], 4)
    cell = cells[5]
    pointed = painter.draw(page, cell)
    left, top, right, bottom = cell.box
    changed = np.any(plain != pointed, axis=2)
    assert changed[top : bottom + 1, left : right + 1].mean() > 0.9
    changed[top : bottom + 1, left : right + 1] = False
    assert not changed.any()
    assert np.array_equal(painter.draw(page, None), plain)


def test_the_pointer_is_a_dot_with_a_rim_that_stands_where_it_points() -> None:
    picture = pointer_picture()
    assert picture.shape == (*inputs.POINTER_SIZE_PX[::-1], 4)
    assert np.array_equal(picture, picture[::-1])
    assert np.array_equal(picture, picture.swapaxes(0, 1))
    middle, corner, rim = picture[16, 16], picture[0, 0], picture[16, 3]
    assert middle.tolist() == [255, 210, 80, 255]
    assert corner[3] == 0
    assert rim.tolist() == [0, 0, 0, 255]
    panel = Quad(Pose(np.array([1.0, 1.5, -2.0]), yaw_pitch_roll(0.4, 0.1, 0.0)), (1.0, 0.75))
    quad = pointer_quad(panel, (0.25, 0.8))
    ray = Pose(quad.pose.position, quad.pose.orientation)
    assert panel.intersection(ray) == pytest.approx((0.25, 0.8))
    assert quad.size_m[0] == quad.size_m[1] == pytest.approx(0.02)


angles = st.floats(-1.2, 1.2)


@given(angles, angles, st.floats(0.02, 0.98), st.floats(0.02, 0.98))
def test_a_ray_aimed_at_a_point_of_a_panel_hits_it(
    yaw: float, pitch: float, right: float, down: float
) -> None:
    quad = Quad(Pose(np.array([1.0, 1.5, -2.0]), yaw_pitch_roll(yaw, pitch, 0.3)), (1.0, 0.75))
    hit = quad.intersection(aim_at(quad, (right, down)))
    assert hit == pytest.approx((right, down), abs=1e-9)


def test_a_ray_from_behind_or_beside_misses() -> None:
    quad = Quad(Pose(np.array([0.0, 0.0, -1.0])), (1.0, 1.0))
    assert quad.intersection(Pose()) == pytest.approx((0.5, 0.5))
    assert quad.intersection(Pose(np.array([0.0, 0.0, -2.0]))) is None
    assert quad.intersection(Pose(np.array([0.6, 0.0, 0.0]))) is None
    assert quad.intersection(Pose(orientation=yaw_pitch_roll(np.pi / 2, 0.0, 0.0))) is None


@cache
def without_question(answers: Answers) -> Picture:
    return Painter().draw(Page("", "", question_cells(answers, first=True)), None)


def test_no_question_of_a_shipped_instrument_reaches_into_its_answers() -> None:
    asked = {
        (item.text, item.answers)
        for instrument in shipped_instruments().values()
        for item in instrument.asked
    }
    for text, answers in asked:
        without = without_question(answers)
        with_question = Painter().draw(Page("", text, question_cells(answers, first=True)), None)
        changed = np.flatnonzero((with_question != without).any(axis=(1, 2)))
        assert changed.size, text
        assert changed.max() < ANSWER_TOP_PX, text


def test_long_questions_are_told_apart_in_the_list_of_answers() -> None:
    asked = shipped_instruments()["csq_vr"]
    texts = [cell.text for cell in review_cells(asked, [1] * 6) if cell.act is Act.CORRECT]
    assert len(set(texts)) == 6
    assert texts[5].startswith("6. Do you")
    assert "…" in texts[5]
    assert texts[5].endswith(": absent")


def drawn_texts(monkeypatch: pytest.MonkeyPatch, page: Page) -> list[tuple[str, int]]:
    """Return what is written on a page, and how large."""
    written: list[tuple[str, int]] = []
    write = TextCanvas.write

    def note(canvas: TextCanvas, place: tuple[float, float], text: str, size_px: int, **more: Any):
        written.append((text, size_px))
        write(canvas, place, text, size_px, **more)

    with monkeypatch.context() as patch:
        patch.setattr(TextCanvas, "write", note)
        Painter().draw(page, None)
    return written


PIXELS_PER_DEGREE = SIZE_PX[0] / 45


def test_no_text_is_smaller_than_it_should_be(monkeypatch: pytest.MonkeyPatch) -> None:
    pages = {}
    for instrument in shipped_instruments().values():
        last = [item.answers.asked[-1] for item in instrument.items]
        if len(last) <= 16:
            pages[instrument.name] = Page("", "", review_cells(instrument, last))
        for item in instrument.asked:
            cells = question_cells(item.answers, first=False)
            pages[item.text, item.answers] = Page("", item.text, cells, ends_of(item.answers))
    canvas = TextCanvas(Image.new("L", (1, 1)))
    for page in pages.values():
        for text, size_px in drawn_texts(monkeypatch, page):
            assert size_px / PIXELS_PER_DEGREE >= 1.4, text
        for cell in page.cells:
            left, top, right, bottom = cell.box
            text = canvas.wrapped(cell.text, SMALL_PX, right - left - 8, hyphens=True)
            assert canvas.height_px(text, SMALL_PX, leading_px=4) <= bottom - top


def test_numbers_of_a_slider_thin_out_and_long_labels_stand_in_lines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tlx = shipped_instruments()["nasa_tlx"].asked[0].answers
    shown = [each.text for each in question_cells(tlx, first=True) if each.act is Act.ANSWER]
    assert [text for text in shown if text] == [str(n) for n in range(0, 101, 10)]
    assert len(shown) == 21
    labels = ("not at all", "einverstandenermaßen", "somewhat", "very much so indeed", "extremely")
    cells = question_cells(Answers(0, 4, labels=labels), first=True)
    texts = dict(drawn_texts(monkeypatch, Page("", "", cells)))
    assert "very much\nso indeed" in texts
    assert min(texts.values()) == SMALL_PX
