"""The vocabulary by which columns are known: TOML files, the shipped ones and a lab's own."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.support.layouts import CONDITIONS, ITEMS, PEOPLE, write
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.importing.suggest.vocabulary import VocabularyFile, read_vocabulary
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.resources import data_folder

SHIPPED = sorted((data_folder("instruments") / "vocabulary").glob("*.toml"))


def answers(folder: Path, person: str, condition: str, words: tuple[str, ...] = ("0", "1")) -> Path:
    """Write answers under headings of a lab's own."""
    rows: list[list[object]] = [[person, condition, *ITEMS]]
    rows += [[p, c, *[words[n % 2]] * 16] for n, p in enumerate(PEOPLE) for c in CONDITIONS]
    return write(folder / "x.csv", rows)


def vocabulary(folder: Path, text: str) -> Path:
    file = folder / "words.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_label_is_added_by_one_line(tmp_path: Path) -> None:
    file = answers(tmp_path, "Zuordnung", "Abdunklung")
    own = vocabulary(
        tmp_path,
        '[facts]\nparticipant.labels = ["zuordnung"]\ncondition.labels = ["abdunklung"]\n',
    )
    unknown = suggest_mapping([file])
    assert any("Does 'Zuordnung' tell participants apart" in doubt for doubt in unknown.doubts)
    assert any("Is 'Abdunklung' the condition" in doubt for doubt in unknown.doubts)
    known = suggest_mapping([file], vocabularies=[own])
    assert not known.doubts
    assert 'participant = { column = "Zuordnung" }' in known.text
    assert 'condition = { column = "Abdunklung" }' in known.text


@pytest.mark.parametrize("shipped", SHIPPED, ids=lambda file: file.stem)
def test_a_shipped_file_with_one_more_line_is_a_vocabulary(shipped: Path, tmp_path: Path) -> None:
    line = {
        "headings": ("[facts.scene]\nlabels = [\n", '  "kulisse",\n'),
        "answers": ("moderate = [", '"ziemlich", '),
        "items": ("sweating = [\n", '  "feuchte hände",\n'),
    }[shipped.stem]
    text = shipped.read_text("utf-8")
    assert line[0] in text
    own = vocabulary(tmp_path, text.replace(line[0], "".join(line), 1))
    rows = [["ID", "Condition", "Kulisse", *ITEMS], *(["P1", c, "wald", *"0" * 16] for c in "ab")]
    rows[0].remove("sweating")
    rows[0].append("Feuchte Hände")  # in no item's place
    rows[1][5:8] = ["none", "ziemlich", "severe"]
    file = write(tmp_path / "x.csv", rows)
    said = {
        "headings": 'scene = { column = "Kulisse" }',
        "answers": "ziemlich = 2",
        "items": 'sweating = "Feuchte Hände"',
    }[shipped.stem]
    assert said not in suggest_mapping([file]).text
    assert said in suggest_mapping([file], vocabularies=[own]).text


def test_a_label_of_ones_own_wins_over_all_shipped_words(tmp_path: Path) -> None:
    file = answers(tmp_path, "Participant", "Session mode")
    assert "session = " in suggest_mapping([file]).text
    own = vocabulary(tmp_path, '[facts.condition]\nlabels = ["session mode"]\n')
    assert (
        'condition = { column = "Session mode" }'
        in suggest_mapping([file], vocabularies=[own]).text
    )


def test_a_covariate_of_ones_own_is_a_column_of_participants(tmp_path: Path) -> None:
    rows = [["ID", "Condition", "Wie lange geschlafen?", *ITEMS]]
    rows += [[p, c, 5 + n, *[n % 4] * 16] for n, p in enumerate(PEOPLE) for c in CONDITIONS]
    file = write(tmp_path / "x.csv", rows)
    own = vocabulary(tmp_path, '[covariates.slept_h]\nlabels = ["Wie lange geschlafen"]\n')
    found = suggest_mapping([file], vocabularies=[own])
    assert 'participants = { slept_h = "Wie lange geschlafen?" }' in found.text


@pytest.mark.parametrize(
    ("heading", "known"),
    [
        ("Welche Linse?", True),
        ("Bitte nennen Sie die Linse, die Sie gerade getragen haben", True),
        (
            "Bitte nennen Sie uns hier noch einmal genau die Linse, die Sie gerade getragen haben",
            False,
        ),
    ],
)
def test_a_word_speaks_for_a_fact_in_headings_of_twelve_words(
    tmp_path: Path, heading: str, known: bool
) -> None:
    file = answers(tmp_path, "ID", heading)
    own = vocabulary(tmp_path, '[facts.condition]\nwords = ["Linse"]\n')
    found = suggest_mapping([file], vocabularies=[own])
    assert any("the condition?" in doubt for doubt in found.doubts) != known


def test_the_command_takes_a_vocabulary(tmp_path: Path) -> None:
    file = answers(tmp_path, "Participant", "Condition", words=("prima", "mies"))
    own = vocabulary(tmp_path, '[severity.de]\nnone = ["prima"]\nsevere = ["mies"]\n')
    asked = ["import", str(file), "--suggest", "--preview"]
    assert "Which answers of ssq" in CliRunner().invoke(app, asked).output
    run = CliRunner().invoke(app, [*asked, "--vocabulary", str(own)])
    assert run.exit_code == 0
    assert "answers = { prima = 0, mies = 3 }" in run.stdout
    assert "question = " not in run.stdout


WRONG = {
    "a key": ('[facts.person]\nlabels = ["a"]\n', "line 1, column 1: unknown key `person`"),
    "a blank label": (
        '[facts.trial]\nlabels = [\n  "a",\n  "?",\n]\n',
        "line 4, column 3: this label",
    ),
    "two roles": (
        '[facts.trial]\nlabels = ["Lauf"]\n\n[facts.block]\nlabels = ["lauf"]\n',
        r"line 5, column 11: this label is of block and of trial; keep one",
    ),
    "a text for a list": ('[facts.trial]\nlabels = "a"\n', "line 2, column 1"),
    "a fact as a covariate": ('[covariates.trial]\nlabels = ["a"]\n', "line 1, .*`trial` is no"),
    "no TOML": ("[facts\n", "line 1"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_vocabulary_is_refused_with_its_line(tmp_path: Path, what: str) -> None:
    text, words = WRONG[what]
    own = vocabulary(tmp_path, text)
    with pytest.raises(InputError, match=words) as refusal:
        suggest_mapping([answers(tmp_path, "ID", "Condition")], vocabularies=[own])
    assert str(refusal.value).startswith(str(own))


def test_names_in_the_shipped_files_are_there() -> None:
    known = shipped_instruments()
    files: list[VocabularyFile] = [read_vocabulary(file) for file in SHIPPED]
    items = {item.name for each in known.values() for item in each.items}
    for file in files:
        assert set(file.items) <= items
        for name, scales in file.scales.items():
            assert set(scales) <= {scale.name for scale in known[name].scales}
        for name, initials in file.initials.items():
            assert set(initials) <= {item.name for item in known[name].items}


def test_the_documented_vocabulary_is_one(tmp_path: Path) -> None:
    page = Path("docs/import.md").read_text(encoding="utf-8")
    shown = "# words.toml" + page.split("```toml\n# words.toml")[1].split("```")[0]
    found = read_vocabulary(vocabulary(tmp_path, shown))
    assert found.facts.participant.labels
    assert found.severity["de"].moderate == ("ziemlich",)
