"""Mappings written by hand: what they can say, and what is refused with its place."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.support.layouts import CONDITIONS, ENGLISH, ITEMS, PEOPLE, Truth, example, study, write
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.importing import import_files, load_mapping, parse_mapping, write_study
from vrcomfort.importing.files import read_tables
from vrcomfort.importing.made_instruments import course_instrument
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.records import QuestionnaireRow

TOP = 'format_version = 1\n[[tables]]\nfiles = ["*"]\n'
SSQ = '[[tables.questionnaires]]\ninstrument = "ssq"\n'


def imported(files: Sequence[Path], text: str) -> Imported:
    return import_files(files, parse_mapping(text, None))


def answers_of(found: Imported) -> Truth:
    return {
        (m.participant, m.condition, m.timepoint): tuple(
            int(response.answers[i] or 0) for i in ITEMS
        )
        for (_, m), response in found.responses.items()
    }


def wide(folder: Path, name: str = "{c}_{t}_{i}") -> tuple[Path, Truth]:
    """One row per person, headings made as `name` has it."""
    truth = study(times=("pre", "post"))
    places = [(c, t) for c in CONDITIONS for t in ("pre", "post")]
    head = ["who", *(name.format(c=c, t=t, i=i) for c, t in places for i in ITEMS)]
    rows = [[p, *(a for c, t in places for a in truth[p, c, t])] for p in PEOPLE]
    file = write(folder / "wide.csv", [head, *rows])
    return file, {(p, c, "baseline" if t == "pre" else "post"): a for (p, c, t), a in truth.items()}


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("{c}_{t}_{i}", 'heading = "{condition}_{timepoint}_{item}"'),
        ("{i} ({t}, {c})", 'heading = "{item} ({timepoint}, {condition})"'),
        ("q.{t}.x17.{c}.{i}", 'heading = "q.{timepoint}.{*}.{condition}.{item}"'),
        (
            "{c}{t}-{i}",
            "pattern = '(?P<condition>blur|plain)(?P<timepoint>pre|post)-(?P<item>.+)'",
        ),
    ],
)
def test_one_template_stands_for_all_headings(tmp_path: Path, name: str, key: str) -> None:
    file, truth = wide(tmp_path, name)
    when = (
        'participant = { column = "who" }\n'
        'timepoint = { values = { pre = "baseline", post = "post" } }\n'
    )
    assert answers_of(imported([file], f"{TOP}{when}{SSQ}{key}\n")) == truth


def rows_of(truth: Truth) -> list[list[object]]:
    return [["who", "what", *ENGLISH], *([p, c, *a] for (p, c, _), a in truth.items())]


FACTS = 'participant = { column = "who" }\ncondition = { column = "what" }\n'


def test_words_and_numbers_can_differ_by_item(tmp_path: Path) -> None:
    truth = study(times=("post",))
    rows = rows_of(truth)
    for row in rows[1:]:
        row[2] = "abcd"[int(str(row[2]))]
        row[3] = int(str(row[3])) + 1
    file = write(tmp_path / "x.csv", rows)
    coding = (
        "[tables.questionnaires.item_coding.general_discomfort]\n"
        "answers = { a = 0, b = 1, c = 2, d = 3 }\n"
        "[tables.questionnaires.item_coding.fatigue]\ncoded_from = 1\n"
    )
    assert answers_of(imported([file], f"{TOP}{FACTS}{SSQ}{coding}")) == truth


def test_reversed_words_and_missing_texts(tmp_path: Path) -> None:
    truth = study(times=("post",))
    turned = [["who", "what", *ENGLISH]]
    turned += [[p, c, *(str(4 - answer) for answer in a)] for (p, c, _), a in truth.items()]
    turned[1][2] = "n/a"
    file = write(tmp_path / "x.csv", turned)
    how = 'answers = { "4" = 0, "3" = 1, "2" = 2, "1" = 3 }\nmissing = ["n/a"]\n'
    found = imported([file], f"{TOP}{FACTS}{SSQ}{how}")
    first = next(iter(found.responses.values()))
    assert first.answers["general_discomfort"] is None
    assert [*first.answers.values()][1:] == [*next(iter(truth.values()))][1:]


def test_short_form_is_kept_as_one(tmp_path: Path) -> None:
    file = write(tmp_path / "x.csv", [["who", "what", "Nausea", "Sweating"], ["a", "b", 1, 2]])
    missing = [item for item in ITEMS if item not in {"nausea", "sweating"}]
    found = imported([file], f"{TOP}{FACTS}{SSQ}not_asked = {json.dumps(missing)}\n")
    assert [response.answers for response in found.responses.values()] == [
        {"nausea": 1, "sweating": 2}
    ]
    assert found.not_asked == {"ssq": tuple(missing)}


def test_exposures_are_numbered_in_the_order_of_rows(tmp_path: Path) -> None:
    truth = study(times=("post",))
    rows = rows_of(truth)
    file = write(tmp_path / "x.csv", [*rows, *rows[1:]])
    found = imported([file], f"{TOP}{FACTS}trial = {{ count = true }}\n{SSQ}")
    trials = [m.trial for _, m in found.responses if m.participant == "P01"]
    assert trials == ["1", "2", "3", "4"]


def test_ratings_during_exposure_have_their_time(tmp_path: Path) -> None:
    rows = [["who", "what", "t", "sick"], ["a", "b", "2,5", 3], ["a", "b", "5,0", ""]]
    file = write(tmp_path / "x.csv", rows, separator=";")
    rating = '[[tables.questionnaires]]\ninstrument = "fms"\ntime = "t"\nitems = { fms = "sick" }\n'
    found = imported([file], f"{TOP}{FACTS}{rating}")
    assert [(r.onset_s, r.response) for r in found.ratings] == [(2.5, 3), (5.0, None)]
    mapping = tmp_path / "map.toml"
    mapping.write_text(f"{TOP}{FACTS}{rating}")
    write_study(tmp_path / "study", found, load_mapping(mapping), [file])
    assert (tmp_path / "study" / "ratings.csv").read_text().splitlines()[1:] == [
        "a,,,b,2.5,,fms,3,0,",
        "a,,,b,5.0,,fms,,1,",
    ]


def test_courses_of_ratings_are_summed_up_for_the_report(tmp_path: Path) -> None:
    rows: list[list[object]] = [["who", "what", "t", "sick"]]
    rows += [["a", "b", time, answer] for time, answer in ((4, 2), (2, 7), (6, ""), (8, 4))]
    file = write(tmp_path / "x.csv", rows)
    rating = (
        '[[tables.questionnaires]]\ninstrument = "fms"\ntime = "t"\n'
        'summaries = ["peak", "mean", "last"]\nitems = { fms = "sick" }\n'
    )
    found = imported([file], f"{TOP}{FACTS}{rating}")
    (((name, _), response),) = found.responses.items()
    assert (name, response.answers) == ("fms_course", {"peak": 7, "mean": 4.3333, "last": 4})
    with pytest.raises(InputError, match="`summaries` are of ratings during exposure"):
        parse_mapping(f"{TOP}{FACTS}{rating.replace('time = ', '# ')}", None)


def test_scores_without_answers_are_kept_as_scores(tmp_path: Path) -> None:
    rows = [["who", "what", "SSQ total", "N"], ["a", "b", "37.4000001", "9.5"], ["a", "c", "", "0"]]
    file = write(tmp_path / "x.csv", rows)
    scores = '[[tables.scores]]\ninstrument = "ssq"\nscales = { T = "SSQ total", N = "N" }\n'
    found = imported([file], f"{TOP}{FACTS}{scores}")
    assert {name for name, _ in found.responses} == {"ssq_scores"}
    assert [(m.condition, response.answers) for (_, m), response in found.responses.items()] == [
        ("b", {"total": 37.4, "nausea": 9.54}),
        ("c", {"total": None, "nausea": 0}),
    ]
    assert found.instruments["ssq_scores"].title.endswith("scores alone")


@pytest.mark.parametrize(
    ("cell", "kind", "words"),
    [
        ("10", "score", "10 is no score of Total severity, which are multiples of 3.74"),
        ("239.36", "score", "up to 235.62"),
        ("2.5", "raw_sum", "multiples of 1 up to 63"),
    ],
)
def test_scores_that_cannot_be_are_refused(
    tmp_path: Path, cell: str, kind: str, words: str
) -> None:
    file = write(tmp_path / "x.csv", [["who", "what", "total"], ["a", "b", cell]])
    scores = f'[[tables.scores]]\ninstrument = "ssq"\nkind = "{kind}"\nscales = {{ T = "total" }}\n'
    with pytest.raises(InputError, match=words) as refusal:
        imported([file], f"{TOP}{FACTS}{scores}")
    assert "row 2, column 'total'" in str(refusal.value)
    as_they_are = scores.replace(f'"{kind}"', '"other"')
    other = imported([file], f"{TOP}{FACTS}{as_they_are}")
    assert [s.answers for s in other.responses.values()] == [{"total": float(cell)}]


def test_scores_alone_are_reported(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Subject", "Condition", "SSQ total", "Nausea", "O", "D"]]
    for n, person in enumerate(PEOPLE):
        for m, condition in enumerate(CONDITIONS):
            sums = (n % 3 + m, n % 4 + 2 * m, n % 2)
            weighted = (9.54 * sums[0], 7.58 * sums[1], 13.92 * sums[2])
            rows.append([person, condition, round(3.74 * sum(sums), 2), *weighted])
    file = write(tmp_path / "totals.csv", rows)
    suggested = suggest_mapping([file])
    assert any("the answers are not there" in doubt for doubt in suggested.doubts)
    mapping = tmp_path / "map.toml"
    mapping.write_text(suggested.text.replace('answer = ""', 'answer = "yes"'))
    run, study_folder, out = CliRunner(), tmp_path / "study", tmp_path / "report"
    made = run.invoke(
        app, ["import", str(file), "--mapping", str(mapping), "--out", str(study_folder)]
    )
    assert made.exit_code == 0, made.output
    shown = run.invoke(app, ["report", str(study_folder), "--figures", "none", "--out", str(out)])
    assert shown.exit_code == 0, shown.output
    results = json.loads((out / "results.json").read_text())
    total = next(t for t in results["tests"] if t["outcome"] == "ssq_scores.total")
    assert total["participants"] == list(PEOPLE)
    assert total["shift"]["estimate"] == pytest.approx(-3 * 3.74)
    assert (total["method"], total["p_exact"]) == ("exact", 2 / 2**10)


BAD: dict[str, tuple[str, list[list[object]], str]] = {
    "word": (
        "",
        [["a", "b", "much"]],
        "row 2, column 'General discomfort': 'much' is not an answer",
    ),
    "high": ("", [["a", "b", 4]], "row 2, column 'General discomfort': '4' is out of range"),
    "part": ("", [["a", "b", 1.5]], "row 2, column 'General discomfort': '1.5' is no whole number"),
    "twice": ("", [["a", "b", 1], ["a", "b", 2]], "row 3.*answered a second time.*x.csv, row 2"),
    "nobody": ("", [["", "b", 1]], "row 2, column 'who': there is no participant"),
    "value": (
        'condition = { column = "what", values = { c = "d" } }',
        [["a", "b", 1]],
        "row 2, column 'what': 'b' is not among the values of condition",
    ),
    "column": ('scene = { column = "hwat" }', [["a", "b", 1]], "'hwat'.*did you mean `what`"),
    "unsaid": ("", [["a", "b", 1]], "'more': is neither mapped nor listed under ignore"),
    "sides": (
        'participants = { age = "more" }',
        [["a", "b", 0, *[0] * 15, 20], ["a", "c", 0, *[0] * 15, 21]],
        "row 3, column 'more': age of a is '20' elsewhere, '21' here",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_is_refused_with_row_and_column(tmp_path: Path, name: str) -> None:
    key, rows, words = BAD[name]
    head = ["who", "what", *ENGLISH, *(["more"] if name in {"unsaid", "sides"} else [])]
    whole = [[*row, *[0] * (len(head) - len(row))] for row in rows]
    file = write(tmp_path / "x.csv", [head, *whole])
    facts = FACTS if "condition" not in key else 'participant = { column = "who" }\n'
    with pytest.raises(InputError, match=words) as refusal:
        imported([file], f"{TOP}{facts}{key}\n{SSQ}")
    assert "x.csv" in str(refusal.value)


MISSAID = {
    'heading = "{condition}_x"': "needs {item}",
    'heading = "{thing}_{item}"': "`thing` is not a fact",
    "pattern = '(?P<item>'": "not a regular expression",
    'item_column = "a"': "go together",
    'instrumnt = "ssq"': "did you mean",
}


@pytest.mark.parametrize("line", MISSAID)
def test_a_mapping_that_makes_no_sense_is_refused(line: str) -> None:
    with pytest.raises(InputError, match=MISSAID[line]):
        parse_mapping(f"{TOP}{SSQ}{line}\n", Path("map.toml"))


def test_an_item_without_a_column_is_refused(tmp_path: Path) -> None:
    file = write(tmp_path / "x.csv", [["who", "what", *ENGLISH[1:]], ["a", "b", *[0] * 15]])
    with pytest.raises(InputError, match=r"no column for general_discomfort.*not_asked"):
        imported([file], f"{TOP}{FACTS}{SSQ}")


def test_where_a_study_came_from_is_kept(tmp_path: Path) -> None:
    file = write(tmp_path / "x.csv", rows_of(study(times=("post",))))
    mapping = tmp_path / "map.toml"
    mapping.write_text(f"{TOP}{FACTS}{SSQ}")
    loaded = load_mapping(mapping)
    study_folder = tmp_path / "study"
    for _ in range(2):  # the second replaces the first
        write_study(study_folder, import_files([file], loaded.mapping), loaded, [file])
    kept = json.loads((study_folder / "import.json").read_text())
    assert kept["sources"] == [
        {
            "file": "x.csv",
            "bytes": file.stat().st_size,
            "sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
        }
    ]
    assert kept["mapping"]["sha256"] == hashlib.sha256(mapping.read_bytes()).hexdigest()
    assert (study_folder / "mapping.toml").read_text() == mapping.read_text()
    (study_folder / "other.txt").write_text("kept")
    with pytest.raises(InputError, match=r"holds other\.txt beside an import"):
        write_study(study_folder, import_files([file], loaded.mapping), loaded, [file])


def test_the_documented_example_is_what_the_command_makes(tmp_path: Path) -> None:
    shipped = Path("tests/data/import/two_displays.csv")
    assert example(tmp_path / shipped.name).read_bytes() == shipped.read_bytes()
    page = Path("docs/import.md").read_text(encoding="utf-8")
    suggested = suggest_mapping([shipped])
    shown = page.split("```toml\n")[1].split("```")[0]
    for line in shown.splitlines():
        assert line.startswith("# …") or line in suggested.text.splitlines(), line
    run = CliRunner().invoke(app, ["import", str(shipped), "--suggest", "--preview"])
    assert run.exit_code == 0
    assert run.stdout == suggested.text
    printed = page.split("```text\n")[1].split("```")[0]
    made = CliRunner().invoke(
        app, ["import", str(shipped), "--suggest", "--out", str(tmp_path / "map.toml")]
    )
    for line in printed.splitlines():
        assert line == "…" or line in made.stdout.splitlines(), line


def test_every_column_of_questionnaires_is_documented() -> None:
    page = Path("docs/import.md").read_text("utf-8")
    for column in (*QuestionnaireRow.columns(), "scene"):
        assert f"`{column}`" in page.split("Columns of `questionnaires.csv`")[1]


def test_a_file_without_doubts_is_reported_without_a_mapping(tmp_path: Path) -> None:
    truth = study(times=("post",))
    rows = [["Participant", "Condition", *ENGLISH], *rows_of(truth)[1:]]
    file = write(tmp_path / "answers.csv", rows, separator=";")
    out = tmp_path / "report"
    run = CliRunner().invoke(app, ["report", str(file), "--figures", "none", "--out", str(out)])
    assert run.exit_code == 0, run.output
    assert "understood without a mapping" in run.stderr
    assert len(json.loads((out / "results.json").read_text())["tests"]) >= 4
    assert (out / "imported" / "mapping.toml").exists()


def test_a_file_with_doubts_is_refused_with_the_command_to_type(tmp_path: Path) -> None:
    truth = study(times=("post",))
    rows = [["Participant", *ENGLISH], *([p, *a] for (p, c, _), a in truth.items() if c == "blur")]
    file = write(tmp_path / "answers.csv", rows)
    with pytest.raises(InputError, match=r"needs a mapping.*No column says the condition") as found:
        CliRunner().invoke(
            app,
            ["report", str(file), "--figures", "none", "--out", str(tmp_path / "r")],
            catch_exceptions=False,
        )
    assert f"vrcomfort import {file} --suggest --out map.toml" in str(found.value)


LONG = '[[tables.questionnaires]]\ninstrument = "ssq"\nitem_column = "item"\n'
LONG += 'response_column = "answer"\n'
LONG_ITEMS = "".join(f'{item} = "{text}"\n' for item, text in zip(ITEMS, ENGLISH, strict=True))


@pytest.fixture
def long_file(tmp_path: Path) -> Path:
    rows = [["a", "b", text, n % 4] for n, text in enumerate(ENGLISH)]
    return write(tmp_path / "x.csv", [["who", "what", "item", "answer"], *rows])


MISSPELT = {
    "an item of the mapping": (
        "Fatigue", "Fatigue", ("fatigue =", "fatige ="),
        r"map\.toml, line \d+, column 1: `fatige` is not an item of ssq; did you mean `fatigue`\?",
    ),
    "an item that was not asked": (
        "Fatigue", "Fatigue", ("\n[tables.q", '\nnot_asked = ["fatige"]\n[tables.q'),
        r"map\.toml, line 11, column 14: `fatige` is not an item of ssq; did you mean `fatigue`\?",
    ),
    "a text of the mapping": (
        "Fatigue", "Fatigue", ('"Fatigue"', '"Fatige"'),
        r"map\.toml, line \d+, column 1: no row has `Fatige` under item; did you mean `Fatigue`\?",
    ),
    "a text of all rows": (
        "Fatigue", "Tired", ("", ""), r"map\.toml.*no row has `Fatigue` under item; it has ",
    ),
    "a text of some rows": (
        "a,b,Fatigue,1", "a,b,Fatigue,1\nc,b,Fatige,1", ("", ""),
        r"x\.csv, row 4, column 'item': 'Fatige' is not an item; is it 'Fatigue'\? Give it under",
    ),
    "rows that count": (
        "Fatigue", "Fatigue", ("\n[tables.q", '\nwhere = { what = "bb" }\n[tables.q'),
        r"map\.toml, line 11, column 11: no row has `bb` under what; did you mean `b`",
    ),
    "a condition": (
        "Fatigue", "Fatigue", ("[[tables]]", 'condition_labels = { bb = "60 Hz" }\n[[tables]]'),
        r"map\.toml, line 2, column 22: no answer is of a condition `bb`; did you mean `b`",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", MISSPELT)
def test_what_is_misspelt_is_refused_and_not_dropped(
    tmp_path: Path, long_file: Path, what: str
) -> None:
    old, new, (right, wrong), words = MISSPELT[what]
    mapping = tmp_path / "map.toml"
    text = f"{TOP}{FACTS}{LONG}\n[tables.questionnaires.items]\n{LONG_ITEMS}"
    mapping.write_text(text, "utf-8")
    arguments = ["import", str(long_file), "--mapping", str(mapping), "--preview"]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    mapping.write_text(text.replace(right, wrong, 1), "utf-8")
    long_file.write_text(long_file.read_text("utf-8").replace(old, new, 1), "utf-8")
    with pytest.raises(InputError, match=words):
        import_files([long_file], load_mapping(mapping).mapping)


def test_items_that_no_row_of_a_long_file_answers_are_said(long_file: Path) -> None:
    text = long_file.read_text("utf-8").replace("Fatigue", "Hunger")
    long_file.write_text(text, "utf-8")
    with pytest.raises(InputError, match=r"line 6, .*no row answers fatigue; give them under"):
        imported([long_file], f"{TOP}{FACTS}{LONG}")
    said = imported([long_file], f'{TOP}{FACTS}{LONG}not_asked = ["fatigue"]\n')
    assert said.notes == ["x.csv: 1 rows of 'Hunger' were left out: no item of that name"]


def test_rows_count_where_a_column_is_blank(long_file: Path) -> None:
    head, *rows = long_file.read_text("utf-8").splitlines()
    lines = [f"{head},note", *(f"{row}," for row in rows), f"{rows[0]},again"]
    long_file.write_text("\n".join(lines), "utf-8")
    found = imported([long_file], f'{TOP}{FACTS}{LONG}where = {{ note = "" }}\n')
    assert found.notes == ["x.csv: 1 rows with 'again' are in no questionnaire of the mapping"]


def test_a_scale_that_an_instrument_does_not_have_is_refused_with_its_place() -> None:
    scores = '[[tables.scores]]\ninstrument = "ssq"\nscales = { Totl = "x" }\n'
    with pytest.raises(InputError, match=r"map\.toml, line 6, column 12: `Totl` is not a scale of"):
        parse_mapping(f"{TOP}{scores}", Path("map.toml"))


@pytest.mark.parametrize(
    ("cells", "answers", "step"),
    [
        (["22.740000000000002", "22.74"], [22.74, 22.74], 0.01),
        (["0.1", "1e-7"], [0.1, 1e-7], 1e-7),
        (["0.30000000000000004", "-1234.5"], [0.3, -1234.5], 0.1),
        (["1e-30", "999999.999999999"], [0, 1e6], 1),
        (["3", "4.0"], [3, 4], 1),
    ],
)
def test_scores_of_any_formula_are_an_instrument(
    tmp_path: Path, cells: list[str], answers: list[float], step: float
) -> None:
    rows = [["who", "what", "total"], *(["a", str(n), cell] for n, cell in enumerate(cells))]
    scores = '[[tables.scores]]\ninstrument = "ssq"\nkind = "other"\nscales = { T = "total" }\n'
    found = imported([write(tmp_path / "x.csv", rows)], f"{TOP}{FACTS}{scores}")
    assert [response.answers["total"] for response in found.responses.values()] == answers
    made = found.instruments["ssq_other_scores"]
    assert made.items[0].answers.step == step
    assert all(made.items[0].answers.has(answer) for answer in answers)


def test_a_score_that_no_instrument_has_is_refused_with_its_place(tmp_path: Path) -> None:
    file = write(tmp_path / "x.csv", [["who", "what", "total"], ["a", "b", "1e13"]])
    scores = '[[tables.scores]]\ninstrument = "ssq"\nkind = "other"\nscales = { T = "total" }\n'
    with pytest.raises(InputError, match=r"row 2, column 'total': 1e13 is larger than any score"):
        imported([file], f"{TOP}{FACTS}{scores}")


def test_a_title_of_any_text_is_that_of_the_instrument_of_courses() -> None:
    ours = replace(shipped_instruments()["fms"], title='The "sick\\ness"\n\x7f', citation='"')
    made = course_instrument(ours, ["peak", "mean"])
    assert made.title == 'The "sick\\ness"\n\x7f, during exposure'
    fine = replace(ours.answers, low=0.00003, high=1.00003, step=0.5)
    finer = replace(ours, answers=fine)
    assert course_instrument(finer, ["mean"]).items[0].answers.low == 0.00003


@pytest.mark.parametrize("name", ["[bold]x[a]", "a*b?", "st\udcfcdy", "a\nb", "=1+1", "\x1b[31m"])
def test_a_file_of_any_name_is_suggested_and_imported(tmp_path, name):
    file = tmp_path / f"{name}.csv"
    rows = [f"P{number}{',1' * len(ITEMS)}" for number in "123"]
    file.write_text("\n".join([",".join(["who", *ITEMS]), *rows]))
    found = suggest_mapping([file])
    assert found.text.encode()
    (tmp_path / "map.toml").write_text(found.text.replace('answer = ""', 'answer = "yes"'), "utf-8")
    loaded = load_mapping(tmp_path / "map.toml")
    imported = import_files([file], loaded.mapping, loaded.instruments)
    assert len(imported.responses) == 3


def test_marks_of_byte_order_are_no_text(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("\ufeffwho,\ufeffcondition\nP1,\ufeff\nP2,a\ufeff b\n", "utf-8")
    (table,) = read_tables(file)
    assert table.headings == ("who", "condition")
    assert table.rows == (("P1", ""), ("P2", "a b"))
