"""What a person writes where a draft is wrong: a line of a vocabulary, and a draft anew."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from tests.support.layouts import CONDITIONS, ENGLISH, ITEMS, PEOPLE, write
from vrcomfort.errors import InputError
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import draft as stakes
from vrcomfort.importing.suggest import suggest_mapping


def told(file: Path, words: str) -> Imported:
    """Return what comes in by the mapping that a lab's own words lead to."""
    own = file.with_name("words.toml")
    own.write_text(words, encoding="utf-8")
    found = suggest_mapping([file], vocabularies=[own]).imported
    assert found is not None
    return found


def items_of(imported: Imported) -> set[str]:
    return {item for response in imported.responses.values() for item in response.answers}


@pytest.fixture
def trials(tmp_path: Path) -> Path:
    """Two displays and three distances each; hits, ease, and the number of a licence."""
    head = [
        "Person",
        "Display",
        "Distance",
        "hit_score",
        "ease_score",
        "sum_x",
        "Licence",
        *ENGLISH,
    ]
    rows = [
        [p, c, d, (n + d) % 2, 1 + (n * d) % 5, n % 3, 100 + n, *[(n + k) % 4 for k in range(16)]]
        for n, p in enumerate(PEOPLE)
        for c in CONDITIONS
        for d in (1, 2, 4)
    ]
    return write(tmp_path / "trials.csv", [head, *rows])


def test_columns_that_a_lab_calls_outcomes_come_in_whatever_they_look_like(trials: Path) -> None:
    drafted = suggest_mapping([trials]).imported
    assert drafted is not None
    assert "sum_x" not in items_of(drafted)
    imported = told(trials, '[outcomes]\nlabels = ["sum_x", "hit_score", "Distance"]\n')
    assert {"sum_x", "hit_score", "distance"} <= items_of(imported)


def test_an_outcome_is_no_item_of_a_questionnaire(tmp_path: Path) -> None:
    rows = [[p, *[(n + k) % 4 for k in range(16)]] for n, p in enumerate(PEOPLE)]
    file = write(tmp_path / "x.csv", [["ID", *ENGLISH], *rows])
    imported = told(file, f'[outcomes]\nlabels = ["{ENGLISH[7]}"]\n')
    ssq = [r for (instrument, _), r in imported.responses.items() if instrument == "ssq"]
    assert ssq
    assert all("nausea" not in response.answers for response in ssq)
    assert "nausea" in items_of(imported)


def test_a_sum_and_yes_or_no_are_outcomes_once_the_lab_says_so(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", *ENGLISH, "total", "weight", "sick"]]
    for n, p in enumerate(PEOPLE):
        said = [(n * k + k) % 4 for k in range(16)]
        rows.append([p, *said, sum(said), f"{60 + n},5", "true" if n % 3 else "false"])
    file = tmp_path / "x.csv"
    file.write_text("\n".join(";".join(map(str, row)) for row in rows), encoding="utf-8")
    words = '[outcomes]\nlabels = ["total", "sick"]\n[people]\nlabels = ["weight"]\n'
    imported = told(file, words)
    for item, place in (("total", 17), ("sick", 19)):
        found = {
            m.participant: r.answers.get(item)
            for (_, m), r in imported.responses.items()
            if item in r.answers
        }
        assert found == {
            row[0]: {"true": 1, "false": 0}.get(str(row[place]), row[place]) for row in rows[1:]
        }
    assert imported.participants["P02"]["weight"] == "61.5"  # written with the table's comma


def test_columns_that_a_lab_calls_peoples_are_facts_named_after_their_headings(
    trials: Path,
) -> None:
    imported = told(trials, '[people]\nlabels = ["Licence"]\n')
    assert imported.participants["P03"]["licence"] == "102"


def test_the_columns_that_a_lab_calls_conditions_are_all_of_them(trials: Path) -> None:
    alone = told(trials, '[facts]\ncondition.labels = ["Display"]\n')
    assert {*alone.conditions} == {*CONDITIONS}
    both = told(trials, '[facts]\ncondition.labels = ["Display", "Distance"]\n')
    assert {*both.conditions} == {f"{c}_{d}" for c in CONDITIONS for d in (1, 2, 4)}


def test_words_of_headings_that_a_lab_calls_conditions_are_no_questions(tmp_path: Path) -> None:
    head = ["ID", *(f"{word}_{n}" for word in ("Pen", "HmD") for n in range(1, 4))]
    rows = [[p, *[(n + k) % 7 for k in range(6)]] for n, p in enumerate(PEOPLE)]
    file = write(tmp_path / "x.csv", [head, *rows])
    drafted = suggest_mapping([file]).imported
    assert drafted is not None
    assert {*drafted.conditions} == {"all"}
    text = '[conditions]\nwords = ["Pen", "HmD"]\n'
    imported = told(file, text)
    assert {*imported.conditions} == {"pen", "hm_d"}
    assert len(items_of(imported)) == 3
    assert 'hm_d = "HmD"' in suggest_mapping([file], vocabularies=[tmp_path / "words.toml"]).text


def test_each_doubt_says_what_to_write_if_it_is_wrong(trials: Path) -> None:
    said = tomllib.loads(suggest_mapping([trials]).text)
    doubts = [*said["doubts"], *said.get("guesses", ())]
    assert doubts
    assert all(doubt["instead"] for doubt in doubts)
    named = [s for s in vars(stakes).values() if isinstance(s, stakes.Stake)]
    assert len(named) > 20
    assert all(stake.instead for stake in named)


def test_what_the_lab_says_of_words_in_headings_and_of_columns_wins(tmp_path: Path) -> None:
    names = [f"{word}_{what}" for word in ("First", "Second") for what in ("HR", "Dig")]
    rows: list[list[object]] = [["ID", *names]]
    rows += [
        [f"P{n}", 60 + 7 * n % 13, n * n % 17, 70 + 5 * n % 11, n**3 % 19] for n in range(1, 9)
    ]
    file = write(tmp_path / "runs.csv", rows)
    drafted = suggest_mapping([file])
    assert drafted.imported is not None
    assert drafted.imported.conditions == ["First", "Second"]
    assert "Do FIRST, SECOND in headings of the same questions say the condition?" in drafted.text
    words = tmp_path / "words.toml"
    words.write_text(f"[outcomes]\nlabels = {json.dumps(names)}\n")
    again = suggest_mapping([file], vocabularies=[words])
    assert again.imported is not None
    assert again.imported.conditions == ["all"]


def test_stimuli_that_the_lab_calls_conditions_are_no_scenes(tmp_path: Path) -> None:
    rows: list[list[object]] = [["participant", "video_id", "valence", "arousal"]]
    rows += [
        [f"P{n}", f"clip_{(n + k) % 20}", 1 + (n + k) % 7, 1 + n * k % 7]
        for n in range(1, 13)
        for k in range(8)
    ]
    words = tmp_path / "words.toml"
    words.write_text('[facts]\ncondition.labels = ["video_id"]\n')
    drafted = suggest_mapping([write(tmp_path / "clips.csv", rows)], vocabularies=[words])
    assert 'condition = { column = "video_id" }' in drafted.text


def test_what_the_lab_calls_participants_and_conditions_are_all_of_them(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Session (of ID)", "Room", "Code", "Set", *ENGLISH]]
    rows += [
        [1 + n % 2, room, n, "ab"[k], *[(n + k) % 4] * 16]
        for room in ("x", "y")
        for n in range(1, 7)
        for k in (0, 1)
    ]
    imported = told(
        write(tmp_path / "x.csv", rows),
        '[facts]\nparticipant.labels = ["Room", "Code"]\ncondition.labels = ["Set"]\n'
        '[ignored]\nlabels = ["Session *"]\n',
    )
    assert {"x_1", "y_6"} < {*imported.participants}
    assert len(imported.participants) == 12
    assert imported.conditions == ["a", "b"]


def test_rows_of_questions_that_the_lab_ignores_are_left_out(tmp_path: Path) -> None:
    rows: list[list[object]] = [["participant", "condition", "item", "answer"]]
    asked = ("comfort", "ease of use", "satisfaction")
    rows += [
        [p, c, text, 1 + (n * k) % 7]
        for n, p in enumerate(PEOPLE)
        for c in CONDITIONS
        for k, text in enumerate(asked, start=1)
    ]
    file = write(tmp_path / "x.csv", rows)
    assert len(items_of(told(file, "[ignored]\nlabels = []\n"))) == 3
    assert len(items_of(told(file, '[ignored]\nlabels = ["ease of use"]\n'))) == 2


def test_a_label_that_no_column_has_is_told(trials: Path) -> None:
    own = trials.with_name("words.toml")
    own.write_text('[people]\nlabels = ["Licence", "Licence no."]\n', encoding="utf-8")
    doubts = suggest_mapping([trials], vocabularies=[own]).doubts
    assert any("No column is called 'Licence no.', as words.toml says" in each for each in doubts)


def test_doubts_that_differ_in_names_alone_are_asked_once() -> None:
    draft = stakes.TomlDraft()
    doubts = [
        stakes.OpenDoubt(f"Does {name!r} tell exposures apart?", "it does", stakes.ORDER)
        for name in ("a", "b", "c")
    ]
    (asked,) = stakes.write_doubts(draft, doubts)
    assert asked.question == "Does 'a' tell exposures apart? (And 2 more like it: 'b', 'c'.)"


def test_outcomes_of_a_log_beside_a_questionnaire_come_in_and_words_without_order_are_asked_about(
    tmp_path: Path,
) -> None:
    trials: list[list[object]] = [["ID", "Condition", "estimate", "colour", "seconds"]]
    asked: list[list[object]] = [["ID", *ENGLISH]]
    for n, p in enumerate(PEOPLE):
        asked.append([p, *[(n + k) % 4 for k in range(16)]])
        trials += [
            [p, c, (n * 7 + k * 11) % 60, ("red", "green", "blue")[(n + k) % 3], k + n / 10]
            for k, c in enumerate([*CONDITIONS] * 15)
        ]
    files = [write(tmp_path / "trials.csv", trials), write(tmp_path / "ssq.csv", asked)]
    words = tmp_path / "words.toml"
    words.write_text('[outcomes]\nlabels = ["estimate", "colour", "seconds"]\n')
    found = suggest_mapping(files, vocabularies=[words])
    assert found.imported is not None
    assert {"estimate", "seconds"} <= items_of(found.imported)
    assert "May 'colour' be left out (they are no numbers" in found.doubts[0]


def test_a_column_that_the_lab_calls_the_condition_beside_conditions_in_headings_is_refused(
    tmp_path: Path,
) -> None:
    words = tmp_path / "words.toml"
    words.write_text('[facts]\ncondition.labels = ["Lens"]\n', encoding="utf-8")
    heads = [f"{display} {item}" for display in ("VR", "AR") for item in ITEMS]
    rows = [[p, "ab"[n % 2], *[(n + k) % 4 for k in range(32)]] for n, p in enumerate(PEOPLE)]
    file = write(tmp_path / "ssq.csv", [["ID", "Lens", *heads], *rows])
    with pytest.raises(InputError, match="'Lens' the condition, but headings of answers say one"):
        suggest_mapping([file], vocabularies=[words])


def test_answers_after_exposure_of_no_condition_are_asked_about(tmp_path: Path) -> None:
    shown = ["", "flat", "deep"]
    head = ["ID", "Condition", *ITEMS, "Which one was best, all in all? (1-7)"]
    rows = [
        [p, shown[(n + k) % 3], *[(n + k + i) % 4 for i in range(16)], ""]
        for n, p in enumerate(PEOPLE)
        for k in range(3)
    ]
    once = [[p, "", *[""] * 16, 1 + n % 7] for n, p in enumerate(PEOPLE)]  # of no condition
    found = suggest_mapping([write(tmp_path / "ssq.csv", [head, *rows, *once])])
    asked = f"Of which condition are {len(PEOPLE)} questionnaires after exposure"
    assert any(doubt.startswith(asked) for doubt in found.doubts)


def test_the_same_answer_of_everybody_is_an_outcome_once_the_lab_says_so(tmp_path: Path) -> None:
    rows = [[p, *[(n + k) % 4 for k in range(16)], 0] for n, p in enumerate(PEOPLE)]
    file = write(tmp_path / "x.csv", [["ID", *ENGLISH, "Stumbles"], *rows])
    drafted = suggest_mapping([file]).imported
    assert drafted is not None
    assert "stumbles" not in items_of(drafted)
    imported = told(file, '[outcomes]\nlabels = ["Stumbles"]\n')
    found = [r.answers["stumbles"] for r in imported.responses.values() if "stumbles" in r.answers]
    assert found == [0] * len(PEOPLE)
