"""Files beside which others say what their columns and numbers mean; and rows of trial runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.importing.test_wordings import answers_in, imported_from
from tests.support.layouts import ENGLISH, write
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.questionnaire import shipped_instruments

ALPHABETICAL = sorted(range(16), key=ENGLISH.__getitem__)
NAMES = [item.name for item in shipped_instruments()["ssq"].items]
WORDS = ["none", "slight", "moderate", "severe"]


def given(person: int, when: int) -> list[int]:
    return [(person + k * when) % 3 for k in range(16)]


def export(file: Path) -> Path:
    columns = [f"SQ{when:02}_{n:02}" for when in (1, 2) for n in range(1, 17)]
    rows: list[list[object]] = [["CASE", "REF", "MODE", "SD02", *columns, "FM01"]]
    rows.append([210, "", "admin", 99, *[1] * 32, 1])
    for person in range(1, 9):
        answers = [given(person, when)[n] + 1 for when in (1, 2) for n in ALPHABETICAL]
        ref = ("cinema", "flight")[person % 2]
        rows.append([210 + person, ref, "interview", 20 + person, *answers, person + 1])
    return write(file, rows)


def codebook(file: Path) -> Path:
    rows: list[list[object]] = [["VAR", "LABEL", "TYPE"], ["SD02", "Age", "TEXT"]]
    for when, moment in enumerate(("before", "after"), start=1):
        for place, item in enumerate(ALPHABETICAL, start=1):
            label = f"Symptoms {moment} VR: {ENGLISH[item]}"
            rows.append([f"SQ{when:02}_{place:02}", label, "ORDINAL"])
    rows.append(["FM01", "Worst nausea in VR (FMS)", "ORDINAL"])
    return write(file, rows)


def values(file: Path) -> Path:
    rows: list[list[object]] = [["VAR", "RESPONSE", "MEANING"]]
    rows += [[f"SQ{w:02}_{n:02}", a + 1, WORDS[a]] for w in (1, 2) for n in (1, 2) for a in (0, 3)]
    rows += [["FM01", 1, "0 (none)"], *(["FM01", n + 1, n] for n in range(1, 21))]
    return write(file, rows)


def test_codebooks_say_items_moments_and_from_where_answers_count(tmp_path: Path) -> None:
    files = [
        export(tmp_path / "data.csv"),
        codebook(tmp_path / "variables.csv"),
        values(tmp_path / "values.csv"),
    ]
    imported = suggest_mapping(files).imported
    assert imported is not None
    said = {
        (instrument, place.participant, place.condition, place.timepoint): dict(each.answers)
        for (instrument, place), each in imported.responses.items()
    }
    expected: dict[tuple[str, ...], dict[str, int]] = {}
    for person in range(1, 9):
        who, where = str(210 + person), ("cinema", "flight")[person % 2]
        expected["ssq", who, where, "baseline"] = dict(zip(NAMES, given(person, 1), strict=True))
        expected["ssq", who, where, "post"] = dict(zip(NAMES, given(person, 2), strict=True))
        expected["fms", who, where, "post"] = {"fms": person}
    assert said == expected
    assert imported.participants["211"]["age"] == "21"


@pytest.mark.parametrize(
    ("told", "first"),
    [("1 = none; 2 = slight; 3 = moderate; 4 = severe", 1), ("0, none | 1, slight | 3, severe", 0)],
)
def test_a_legend_in_one_row_for_several_columns_says_what_numbers_mean(
    told: str, first: int, tmp_path: Path
) -> None:
    columns = [f"ssq{n:02}" for n in range(1, 17)]
    rows: list[list[object]] = [["id", "group", *columns]]
    rows += [[n, n % 2 + 1, *(first + a for a in given(n, 1))] for n in range(1, 9)]
    rows[1][2] = first + 1  # no answer is the lowest in some columns
    book: list[list[object]] = [["Variable", "Values"], ["group", "1 = blur; 2 = plain"]]
    book += [["ssq01 to ssq16", told], ["id", ""]]
    files = [write(tmp_path / "data.csv", rows), write(tmp_path / "codes.csv", book)]
    imported = suggest_mapping(files).imported
    assert imported is not None
    assert {place.condition for _, place in imported.responses} == {"blur", "plain"}
    assert answers_in(imported)[1] == given(2, 1)


def test_answers_of_which_only_the_later_say_when_are_before_and_after(tmp_path: Path) -> None:
    later = [f"Now, AFTER the virtual tour, how strong is it? - {item}" for item in ENGLISH]
    asked = [f"How strong is it? - {item}" for item in ENGLISH]
    rows: list[list[object]] = [["id", *asked, *later, "headset"]]
    rows += [[n, *given(n, 1), *given(n, 2), "ab"[n % 2]] for n in range(1, 9)]
    file = write(tmp_path / "tour.csv", rows)
    assert {(p.condition, p.timepoint) for _, p in imported_from(file).responses} == {
        (headset, when) for headset in "ab" for when in ("baseline", "post")
    }
    assert any("before exposure?" in doubt for doubt in suggest_mapping([file]).doubts)


def test_answers_in_own_words_are_nobody_s_covariate_and_test_is_nobody(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", "condition", "What is your gender?", *ENGLISH, "Comments?"]]
    for n in range(1, 7):
        rows += [[f"P{n}", c, "fm"[n % 2], *given(n, 1), "too hot" if n < 3 else ""] for c in "ab"]
    rows.append(["Test", "a", "f", *[3] * 16, "does it work"])
    imported = imported_from(write(tmp_path / "form.csv", rows))
    assert imported.participants == {f"P{n}": {"gender": "fm"[n % 2]} for n in range(1, 7)}
