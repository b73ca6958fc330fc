"""Pages and tables of names that somebody chose to do harm: nothing runs, nothing crashes."""

import csv
import io
import json
import re
from collections.abc import Callable
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.support.browser import open_page
from tests.support.report import Study, build_report, foreign, planned_report
from vrcomfort.errors import InputError
from vrcomfort.report import ReportSummary
from vrcomfort.report.tables import inert, to_csv
from vrcomfort.report.writing import LONGEST_BYTES, file_name
from vrcomfort.resources import data_folder
from vrcomfort.web_page import POLICY, escape_hidden, inline_svg, page_templates, policy_with

ONERROR = "<img src=x onerror=document.title='ran'>"
SCRIPT = "\"'></style></svg><script>document.title='ran'</script>"
COMMENT = "--><svg onload=document.title='ran'>"
HOSTILE = {
    "mixed": (ONERROR, "a\\q", r"$\frac{$", "=1+1"),
    "html": (ONERROR, SCRIPT, COMMENT, "&amp;"),
    "attributes": ('" onmouseover="document.title=1', "javascript:alert(1)", "{{ 7 * 7 }}"),
    "backslashes": ("a\\q", r"\g<1>", r"C:\con", "\\u0000"),
    "dollars": (r"$\frac{$", "$a$", "$$", "%s{0}"),
    "formulas": ("=1+1", "+cmd|' /C calc'!A0", "-x", "@SUM(A1)", "\t=2"),
    "lines": ("a\nb", "\x1b[31mred", "a\rb", "\x07"),
    "long": ("x" * 5000, "long words " * 300),
    "scripts": ("\u202eabc", "\u0645\u0631\u062d\u0628\u0627", "日本語", "👩‍🔬"),
    "empty": ("\u3164", "\u200b", "\u2800", "."),
    "columns": ("outcome", "participant", "T", "C(condition)", "Intercept"),
}


def hostile_study(folder: Path, names: tuple[str, ...]) -> Path:
    """Return a study whose conditions, labels, title, people, scenes and notes have these names."""
    study = Study(folder)
    for index in range(4):
        person = f"{names[index % len(names)]}{index}"
        study.person(person, names[-1], "withdrawn" if index == 3 else "completed", names[0])
        exposures = [(name, names[1], (index * 7 + 3 * k) % 11) for k, name in enumerate(names)]
        status = "withdrawn" if index == 3 else "completed"
        exposures = exposures[: 1 if index == 3 else None]
        study.session(person, 1, index % 2, exposures, status, place=f"sub-{index}")
    labels = dict(zip(names, reversed(names), strict=True))
    text = json.dumps({"name": names[0], "protocol": names[1], "conditions": labels})
    (folder / "dataset_description.json").write_text(text)
    return folder


KINDS = [pytest.param(kind, marks=() if kind == "mixed" else pytest.mark.slow) for kind in HOSTILE]


@pytest.fixture(scope="module")
def reports(tmp_path_factory) -> Callable[[str], ReportSummary]:
    """Return the report on a kind of names, made once."""

    @cache
    def report(kind: str) -> ReportSummary:
        folder = tmp_path_factory.mktemp(kind)
        study = hostile_study(folder / "s", HOSTILE[kind])
        return build_report(study, out=folder / "o", forms=("svg",))

    return report


class Elements(HTMLParser):
    """Collects the names of elements and of their attributes."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: set[str] = set()
        self.attributes: set[str] = set()
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.found.add(tag)
        self.attributes.update(name for name, _ in attrs)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_report_on_any_names_is_written_and_has_only_its_own_elements(reports, kind):
    summary = reports(kind)
    text = summary.index.read_text("utf-8")
    own = f"<script>{(data_folder('analysis') / 'report' / 'page.js').read_text('utf-8')}</script>"
    assert text.count(own) == 1
    page = Elements(text.replace(own, ""))
    assert not page.found & {"script", "img", "iframe", "object", "embed", "base", "form", "link"}
    assert not [name for name in page.attributes if name.startswith("on")]
    assert len(summary.figures) >= 3


@pytest.mark.parametrize("kind", KINDS)
def test_every_cell_of_the_reports_tables_is_inert(reports, kind):
    summary = reports(kind)
    for table in summary.tables:
        header, *rows = csv.reader(io.StringIO(table.read_bytes().decode(), newline=""))
        assert {len(row) for row in rows} == {len(header)}
        for row in (header, *rows):
            for cell in row:
                assert not cell.startswith(("=", "+", "@", "\t", "\r")), (table.name, cell)
                if cell.startswith("-"):
                    float(cell)


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.parametrize("kind", HOSTILE)
def test_in_a_browser_nothing_of_a_report_on_hostile_names_runs(reports, browser, kind):
    summary = reports(kind)
    opened = open_page(browser, summary.index)
    assert "<title>ran</title>" not in opened.dom
    assert ": report</title>" in opened.dom
    assert opened.refused == ()  # nothing got so far that the policy had to stop it
    assert opened.dom.count("<figure") == opened.dom.count("</figure>") >= 3
    assert "An interval of the shift needs" in opened.dom  # the page is whole to its end
    assert '<button id="copy" type="button">' in opened.dom  # its own script is allowed to run


@pytest.mark.slow
@pytest.mark.browser
def test_a_page_without_a_policy_would_run_what_the_test_looks_for(tmp_path, browser):
    page = tmp_path / "page.html"
    for attack in (ONERROR, SCRIPT, COMMENT):
        page.write_text(f"<!DOCTYPE html><title>page</title>{attack}")
        assert "<title>ran</title>" in open_page(browser, page).dom, attack


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.parametrize("attack", [ONERROR, SCRIPT, "<svg onload=document.title='ran'>"])
def test_what_got_into_a_page_unescaped_would_not_run_all_the_same(tmp_path, browser, attack):
    scores = {f"P{i}": {"a": i, "b": 2} for i in range(3)}
    summary = build_report(foreign(tmp_path / "questionnaires.csv", scores), out=tmp_path / "o")
    page = summary.index.read_text("utf-8").replace("</h1>", f"</h1>{attack}", 1)
    summary.index.write_text(page, "utf-8")
    opened = open_page(browser, summary.index)
    assert "<title>ran</title>" not in opened.dom
    assert opened.refused


@pytest.mark.parametrize("template", ["report.html.j2", "tradeoff.html.j2"])
def test_every_page_has_the_policy_before_anything_else_that_counts(template):
    source, _, _ = page_templates().loader.get_source(page_templates(), template)
    head = source[source.index("<head>") :]
    assert head.index("Content-Security-Policy") < head.index("<title>") < head.index("<style>")
    own = "<script>{{ script }}</script>"
    assert source.count("<script") == source.count(own) == (template == "report.html.j2")
    assert "| safe" not in source
    assert "default-src 'none'" in POLICY
    assert "script-src" not in POLICY
    assert policy_with("a()").startswith(f"{POLICY}; script-src 'sha256-")
    assert "unsafe" not in policy_with("a()").partition("script-src")[2]


def test_a_text_that_begins_like_a_formula_is_inert():
    for cell in ("=1", "+a", "-a", "@a", "\ta", "\ra", "=", "-", "+1+cmd", "-1e", "'=1", "''-a"):
        assert inert(cell) == f"'{cell}"


def test_numbers_and_plain_texts_stay_what_they_are():
    for cell in (-1.5, -3, None, True, "-1.5", "+2", "-1e-05", "a=b", "", "'a", "'1"):
        assert inert(cell) is cell


def test_the_names_of_columns_are_inert_too():
    assert to_csv([{"=1+1": -1.5, "b": "-x"}]) == "'=1+1,b\n-1.5,'-x\n"


def test_records_are_not_altered_by_a_report(tmp_path):
    source = foreign(tmp_path / "questionnaires.csv", {"=P1": {"=1+1": 3, "@b": 2}})
    before = source.read_bytes()
    planned_report(source, out=tmp_path / "o")
    assert source.read_bytes() == before


def test_what_nobody_sees_is_written_out():
    assert escape_hidden("a\u202eb\x00\u200b\tc\n") == "a\\u202eb\\u0000\\u200b\tc\n"
    assert escape_hidden("مرحبا 日本語 👩‍🔬 é") == "مرحبا 日本語 👩‍🔬 é"


def test_an_svg_has_ids_of_its_own_whatever_its_name_is():
    svg = '<?xml?><svg width="1"><g id="a"/><use xlink:href="#a" clip-path="url(#a)"/></svg>'
    for name in ('"><script>', "a\\q", "\\g<1>", "a b", "", "é"):
        found = inline_svg(svg, name)
        (own,) = set(re.findall(r'id="([\w.-]+)-a"', found))
        assert f'href="#{own}-a"' in found
        assert f"url(#{own}-a)" in found
        assert own not in inline_svg(svg, f"{name}2")


def test_a_figure_has_a_file_name_that_every_system_takes():
    hostile = {name for kind in HOSTILE.values() for name in kind}
    names = {file_name(f"paired_T_{name}_b") for name in hostile}
    assert len(names) == len(hostile)
    assert max(len(name.encode()) for name in names) <= LONGEST_BYTES
    assert not any(sign in name for name in names for sign in '/\\:*?"<>|\n\r\t\x1b\x07')


@pytest.mark.parametrize("name", ["item", "difference"])
def test_a_condition_that_would_hide_a_column_of_the_tables_is_refused(tmp_path, name):
    source = foreign(tmp_path / "questionnaires.csv", {"P1": {name: 3, "b": 2}})
    with pytest.raises(InputError, match=f"called `{name}`"):
        build_report(source, out=tmp_path / "o")
