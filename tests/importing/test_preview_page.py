"""The page of an import: the files, coloured by role, and the mapping beside them."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.support.lab_layouts import glued_moments
from tests.support.layouts import example, spss_wide, write
from vrcomfort.cli.app import app
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.web_page import POLICY


def page_of(*words: object) -> str:
    """Return the page that a command writes as its last argument."""
    made = CliRunner().invoke(app, ["import", *map(str, words)])
    assert made.exit_code == 0, made.output
    return Path(str(words[-1])).read_text(encoding="utf-8")


def kinds(page: str) -> dict[str, str]:
    """Return heading → kind of its column."""
    head = page.split("<thead>")[1].split("</tr>", maxsplit=1)[0]
    return {
        unescape(name): kind
        for kind, name in re.findall(r'<th class="(\w+)" title="[^"]*">([^<]*)</th>', head)
    }


@pytest.fixture(scope="module")
def previewed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Return a file, and the page of the mapping that is suggested for it."""
    folder = tmp_path_factory.mktemp("previewed")
    file = example(folder / "two_displays.csv")
    return file, page_of(file, "--suggest", "--preview", folder / "page.html")


def test_columns_have_the_colour_of_their_role(previewed: tuple[Path, str]) -> None:
    _, page = previewed
    found = kinds(page)
    assert found["VP-Code"] == "participant"
    assert found["Display"] == "condition"
    assert found["Age"] == "covariate"
    assert found["Pre: Nausea"] == found["Post: Nausea"] == "answer"
    assert found["Zeitstempel"] == found["Total post"] == "ignored"
    assert 'title="SSQ: nausea (Post)"' in page


def test_the_mapping_can_be_copied_from_the_page_as_it_is(previewed: tuple[Path, str]) -> None:
    file, page = previewed
    field = page.split('wrap="off">\n')[1].split("</textarea>")[0]
    assert unescape(field) == suggest_mapping([file]).text


def test_the_page_runs_nothing_and_escapes_what_files_say(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "Condition", "<script>alert(1)</script>", "SSQ_T"]]
    rows += [[f"P{n}", "ab"[n % 2], "</textarea><b>", 3.74 * n] for n in range(8)]
    file = write(tmp_path / "x.csv", rows)
    page = page_of(file, "--suggest", "--preview", tmp_path / "page.html")
    assert POLICY.replace("'", "&#39;") in page
    assert "<script" not in page
    assert page.count("</textarea>") == 1
    assert "<b>" not in page.split("<tbody>")[1].split("</tbody>")[0]


def test_doubts_stand_with_their_consequence_and_rows_left_out_are_struck(tmp_path: Path) -> None:
    (file,), _ = glued_moments(tmp_path)
    page = page_of(file, "--suggest", "--preview", tmp_path / "page.html")
    assert "If not: every answer would count for another symptom." in unescape(page)
    assert page.count('<tr class="out">') == 1


def test_a_mapping_that_is_refused_is_shown_with_the_reason(tmp_path: Path) -> None:
    (file,), _ = spss_wide(tmp_path)
    mapping = tmp_path / "map.toml"
    text = suggest_mapping([file]).text.replace('participant = { column = "VPN" }', "")
    mapping.write_text(text + '\n[[doubts]]\nquestion = "Open?"\n', encoding="utf-8")
    made = CliRunner().invoke(
        app, ["import", str(file), "--mapping", str(mapping), "--preview", str(tmp_path / "p.html")]
    )
    assert made.exit_code == 0, made.output
    assert "is neither mapped nor listed under ignore" in made.stderr
    page = unescape((tmp_path / "p.html").read_text(encoding="utf-8"))
    assert "is neither mapped nor listed under ignore" in page
    assert "Open?" in page


def test_another_page_is_not_replaced(tmp_path: Path) -> None:
    file, other = example(tmp_path / "two_displays.csv"), tmp_path / "other.html"
    other.write_text("<p>mine</p>", encoding="utf-8")
    made = CliRunner().invoke(app, ["import", str(file), "--suggest", "--preview", str(other)])
    assert made.exit_code != 0
    assert other.read_text(encoding="utf-8") == "<p>mine</p>"
    own = tmp_path / "own.html"
    for _ in range(2):
        page_of(file, "--suggest", "--preview", own)


@pytest.mark.parametrize("words", [["--preview"], []])
def test_without_a_page_none_is_written(words: list[str], tmp_path: Path) -> None:
    file = example(tmp_path / "two_displays.csv")
    made = CliRunner().invoke(app, ["import", str(file), "--suggest", *words])
    assert made.exit_code == 0
    assert made.stdout == suggest_mapping([file]).text
    assert [each.name for each in tmp_path.iterdir()] == [file.name]


def test_each_part_of_a_sheet_is_shown_as_a_table_of_its_own(tmp_path: Path) -> None:
    loads = ["Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort"]
    rows: list[list[object]] = []
    for condition in ("Teleport", "Joystick"):
        rows += [[condition], ["ID", *loads, "Frustration"]]
        rows += [[f"P{n}", *(5 * ((n * k) % 21) for k in range(1, 7))] for n in range(1, 8)]
        rows += [[]]
    file = write(tmp_path / "NASA-TLX.csv", rows)
    page = page_of(file, "--suggest", "--preview", tmp_path / "page.html")
    assert "NASA-TLX.csv, sheet Teleport" in page
    assert "NASA-TLX.csv, sheet Joystick" in page
    assert "not understood" not in page
