"""Figures of a report are drawn where they are asked for, in the forms that are asked for."""

import io
import json

import numpy as np
import pytest
from PIL import Image

from tests.support.report import carnegie_like, foreign
from vrcomfort.report import build_report
from vrcomfort.report.canvas import canvas, dots
from vrcomfort.report.estimation import draw_difference

SCORES = {f"P{i}": {"a": 3 + i, "b": 2 * i} for i in range(6)}
PLAN = 'name = "mine"\ntitle = "Mine"\noutcomes = ["T"]\nfigures = ["paired"]\n'


@pytest.fixture
def source(tmp_path):
    """One file, and a plan beside it with one figure beside the flow."""
    (tmp_path / "plan.toml").write_text(f'{PLAN}[[contrasts]]\na = "a"\nb = "b"\n', "utf-8")
    return foreign(tmp_path / "questionnaires.csv", SCORES)


@pytest.mark.slow
def test_a_page_without_figures_has_the_same_numbers_and_speaks_of_none(tmp_path, source):
    plan, out = tmp_path / "plan.toml", tmp_path / "o"
    drawing = build_report(source, plan=plan, out=out, forms=("svg",))
    page, found = (file.read_text("utf-8") for file in (drawing.index, drawing.results))
    assert page.count("<figure>") == len(drawing.figures) == 2
    assert "every figure in <code>figures/</code> as SVG. " in page
    assert "Estimation plots (Gardner" in page
    plain = build_report(source, plan=plan, out=out, forms=())
    assert not plain.figures
    assert not list((out / "figures").iterdir())  # those of the report before
    page = plain.index.read_text("utf-8")
    for words in ("<figure", "<svg", "figures/", "Estimation plots", "Gardner", "Blom"):
        assert words not in page
    one, other = (json.loads(text) for text in (found, plain.results.read_text("utf-8")))
    assert one.pop("files") != other.pop("files")
    assert one == other


@pytest.mark.slow
@pytest.mark.smoke
def test_the_command_writes_the_forms_that_are_asked_for(run, tmp_path, source):
    words = ("report", source, "--plan", tmp_path / "plan.toml", "--out", tmp_path / "o")
    assert run(*words, "--figures", "pdf, svg")[0] == 0
    suffixes = sorted(path.suffix for path in (tmp_path / "o" / "figures").iterdir())
    assert suffixes == [".pdf", ".pdf", ".svg", ".svg"]
    page = (tmp_path / "o" / "index.html").read_text("utf-8")
    assert "as SVG and PDF. " in page
    assert run(*words, "--figures", "none")[0] == 0
    assert "<figure" not in (tmp_path / "o" / "index.html").read_text("utf-8")


@pytest.mark.parametrize("wrong", ["gif", "", "svg,none"])
def test_a_form_that_is_none_is_told_with_those_that_are(run, tmp_path, source, wrong):
    code, _, err = run("report", source, "--out", tmp_path / "o", "--figures", wrong)
    assert code == 2
    assert "write none, or some of svg, png, pdf" in " ".join(err.split())
    assert not (tmp_path / "o").exists()


@pytest.mark.parametrize("people", [1, 2000])
def test_dots_are_seen_in_pixels(people):
    def red(values):
        with canvas("dots", 3, 2) as (figure, drawing):
            axes = figure.add_subplot()
            dots(axes, np.linspace(0, 1, people), values, "#ff0000")
            axes.axis((-0.1, 1.1, -0.1, 1.1))
        pixels = np.asarray(Image.open(io.BytesIO(drawing.png())).convert("RGB"), dtype=int)
        return int(((pixels[..., 0] > 200) & (pixels[..., 1] < 80)).sum())

    assert red(np.full(people, np.nan)) == 0
    assert red(np.linspace(0, 1, people)) > 50 * min(people, 40)


@pytest.mark.parametrize(("estimate", "drawn"), [(2.0, [[1.5, 2.5], [2.0]]), (None, [[1.5, 2.5]])])
def test_a_difference_stands_upright_with_its_interval(estimate, drawn):
    with canvas("difference", 3, 2) as (figure, _):
        axes = figure.add_subplot()
        draw_difference(axes, 1.0, estimate, 1.5, 2.5)
    assert [np.atleast_1d(line.get_ydata()).tolist() for line in axes.lines] == drawn
    assert {float(x) for line in axes.lines for x in np.atleast_1d(line.get_xdata())} == {1.0}


@pytest.mark.slow
def test_figures_come_as_svg_png_and_pdf_with_the_same_bytes_each_time(tmp_path):
    source = foreign(tmp_path / "questionnaires.csv", SCORES)
    one = build_report(source, out=tmp_path / "o")
    begins = {".svg": b"<?xml", ".png": b"\x89PNG", ".pdf": b"%PDF"}
    names = {path.stem for path in one.figures}
    assert {path.name for path in one.figures} == {f"{n}{form}" for n in names for form in begins}
    for path in one.figures:
        assert path.read_bytes().startswith(begins[path.suffix])
    again = build_report(source, out=tmp_path / "p")
    assert [p.read_bytes() for p in one.figures] == [p.read_bytes() for p in again.figures]


@pytest.mark.slow
def test_no_figure_of_an_earlier_report_stays(tmp_path):
    carnegie_like(tmp_path / "study")
    other = foreign(tmp_path / "questionnaires.csv", SCORES)
    first = build_report(tmp_path / "study", out=tmp_path / "again", forms=("svg",))
    again = build_report(other, out=tmp_path / "again", forms=("svg",))
    removed = {path.name for path in {*first.figures} - {*again.figures}}
    assert "exposures.svg" in removed
    left = {path.name for path in (tmp_path / "again" / "figures").iterdir()}
    assert left == {path.name for path in again.figures}
