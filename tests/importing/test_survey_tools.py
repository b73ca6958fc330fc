"""Exports of survey tools and experiment programs: codes, codebooks, forms again, events, sums."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from tests.support.layouts import write
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import Suggestion, suggest_mapping
from vrcomfort.questionnaire import shipped_instruments

VRSQ = [item.name for item in shipped_instruments()["vrsq"].items]
PEOPLE = [f"x{n}k{7 * n % 10}" for n in range(1, 11)]


def draw(*places: object) -> random.Random:
    return random.Random(str(places))  # noqa: S311


def severity(*places: object) -> list[int]:
    return draw(*places).choices(range(4), (5, 3, 2, 1), k=9)


def imported(found: Suggestion) -> Imported:
    assert found.imported is not None, found.doubts
    return found.imported


def answers(found: Suggestion, instrument: str) -> dict[tuple[str, str], list[object]]:
    """Return (participant, condition) → answers."""
    responses = imported(found).responses.items()
    return {
        (m.participant, m.condition): [*r.answers.values()]
        for (name, m), r in responses
        if name == instrument
    }


@pytest.mark.parametrize("code", ["V{n:02d}", "Q[SQ{n:03d}]"])
def test_codes_of_a_limesurvey_are_symptoms_and_its_token_is_the_person(
    code: str, tmp_path: Path
) -> None:
    rows: list[list[object]] = [
        ["id", "submitdate", "token", "COND", *(code.format(n=n) for n in range(1, 10))]
    ]
    for who in PEOPLE:
        for c in ("Vignette", "None"):
            rows.append([len(rows), "2024-05-01", who, c, *severity(who, c)])
    found = suggest_mapping([write(tmp_path / "survey.csv", rows)])
    said = {(p, c): severity(p, c) for p in PEOPLE for c in ("Vignette", "None")}
    assert answers(found, "vrsq") == said
    assert any("VRSQ and MSSQ_ADULT, MSSQ_CHILD have as many items" in d for d in found.doubts)


def test_codes_to_which_conditions_are_glued_are_one_question(tmp_path: Path) -> None:
    head = [f"V{n:02d}{c}" for c in "AB" for n in range(1, 10)]
    rows: list[list[object]] = [["id", "token", *head, "COMFA", "COMFB"]]
    rows += [
        [n, who, *severity(who, "A"), *severity(who, "B"), 1 + n % 7, 1 + 3 * n % 7]
        for n, who in enumerate(["test", *PEOPLE], start=1)
    ]
    found = suggest_mapping([write(tmp_path / "survey.csv", rows)])
    assert {c for _, c in answers(found, "vrsq")} == {"A", "B"}
    assert answers(found, "own_questions")["3", "B"] == [3]
    assert len(imported(found).participants) == len(PEOPLE)
    assert any("with 'test' in 'token'" in doubt for doubt in found.doubts)


def test_a_codebook_of_questions_and_their_parts_names_columns(tmp_path: Path) -> None:
    texts = [item.text for item in shipped_instruments()["vrsq"].items]
    order = [3, 1, 4, 8, 0, 6, 2, 7, 5]
    rows: list[list[object]] = [["token", "COND", *(f"QC[SQ{n:03d}]" for n in range(1, 10))]]
    rows += [
        [who, c, *(severity(who, c)[place] for place in order)] for who in PEOPLE for c in "ab"
    ]
    book: list[list[object]] = [["Code", "Question", "Part", "Text", "Answer code", "Answer"]]
    book += [
        ["QC", "How much now?", f"SQ{n:03d}", texts[place], a, text]
        for n, place in enumerate(order, start=1)
        for a, text in enumerate(("None", "Slight", "Moderate", "Severe"))
    ]
    files = [write(tmp_path / "data.csv", rows), write(tmp_path / "codebook.csv", book)]
    responses = imported(suggest_mapping(files)).responses.items()
    said = {(m.participant, m.condition): r.answers for (_, m), r in responses}
    assert len(said) == 2 * len(PEOPLE)
    for (who, c), given in said.items():
        assert given == dict(zip(VRSQ, severity(who, c), strict=True))


def test_events_that_ask_are_questions_among_others(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Timestamp", "User", "TrialIndex", "Technique", "Event", "Value"]]
    for n in range(1, 11):
        for k, c in enumerate(("Snap", "Smooth"), start=1):
            who, said = f"P{n:02d}", draw(n, c)
            for event, value in (
                ("TrialStart", ""),
                *(("Collision", f"Wall{j}") for j in range(said.randint(1, 4))),
                ("ComfortRating", said.randint(1, 7)),
                ("TrialEnd", ""),
            ):
                rows.append([len(rows) * 1.5, who, k, c, event, value])
    found = answers(suggest_mapping([write(tmp_path / "log.csv", rows)]), "own_questions")
    assert {c for _, c in found} == {"Snap", "Smooth"}
    rated = {(r[1], r[3]): [r[5]] for r in rows if r[4] == "ComfortRating"}
    assert found == rated


def test_of_two_clocks_the_one_that_begins_anew_times_ratings(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Time", "FrameTime", "Subject", "Condition", "Trial", "FMS"]]
    for n in range(1, 6):
        for k, c in enumerate(("Low", "High"), start=1):
            rows += [[60 * m, 1000 * n + 450 * k + 60 * m, n, c, k, m + k] for m in range(6)]
    ratings = imported(suggest_mapping([write(tmp_path / "log.csv", rows)])).ratings
    assert [(r.onset_s, r.response) for r in ratings[:6]] == [(60 * m, m + 1) for m in range(6)]


def test_a_form_that_asks_again_numbers_its_questions(tmp_path: Path) -> None:
    asked = ["I felt comfortable during the ride", "I felt dizzy", "The image was sharp"]
    rows: list[list[object]] = [
        ["ID", "Participant code", *(f"{q}{n}" for n in ("", 2, 3) for q in asked)]
    ]
    rows += [[n, f"A{n:02d}", *draw(n).choices(range(1, 6), k=9)] for n in range(1, 11)]
    found = answers(suggest_mapping([write(tmp_path / "form.csv", rows)]), "own_questions")
    assert found == {
        (str(r[1]), str(c + 1)): r[2:][3 * c : 3 * c + 3] for r in rows[1:] for c in range(3)
    }


def test_numbers_before_questions_of_later_forms_make_no_other_questions(tmp_path: Path) -> None:
    asked = [f"How {what} did you feel? (1-7)" for what in ("comfortable", "dizzy", "safe")]
    files = []
    for place, c in enumerate(("Walking", "Teleport", "Joystick")):
        named = [f"{n}. {q}" if place else q for n, q in enumerate(asked, start=1)]
        rows: list[list[object]] = [["Timestamp", "Participant ID", *named]]
        rows += [["2024/05/01", f"P{n}", *draw(n, c).choices(range(1, 8), k=3)] for n in range(10)]
        files.append(write(tmp_path / f"{c} (Responses).csv", rows))
    found = answers(suggest_mapping(files), "own_questions")
    assert {c for _, c in found} == {"Walking", "Teleport", "Joystick"}
    assert len(found) == 30


def test_sums_differences_and_reversed_answers_are_no_questions(tmp_path: Path) -> None:
    asked = ("calm", "dizzy", "tired")
    head = [f"{t}_{q}" for t in ("pre", "post") for q in asked]
    rows: list[list[object]] = [["id", "condition", *head, "post_mean", "rise", "all", "calm_rev"]]
    for n in range(1, 13):
        for c in ("fast", "slow"):
            a, b = draw(n, c).choices(range(1, 8), k=3), draw(c, n).choices(range(1, 8), k=3)
            mean = round(sum(b) / 3, 2)
            rows.append([f"P{n}", c, *a, *b, mean, sum(b) - sum(a), sum(a) + sum(b), 8 - a[0]])
    found = suggest_mapping([write(tmp_path / "x.csv", rows)])
    items = {i for r in imported(found).responses.values() for i in r.answers}
    assert items == {*asked}
    made = json.dumps(["post_mean", "rise", "all", "calm_rev"])
    assert f"ignore = {made}" in found.text


def test_codes_with_a_condition_before_their_questions_say_it(tmp_path: Path) -> None:
    sus = [(item.name, item.text) for item in shipped_instruments()["sus"].items]
    head = [f"SYS{c}[{name}]. Please rate this. [{text}]" for c in "AB" for name, text in sus]
    head += [f"PREF{c}. How pleasant was it?" for c in "AB"]
    rows: list[list[object]] = [["Participant code", *head]]
    rows += [
        [f"K{n}", *draw(n).choices(range(1, 6), k=20), n % 7 + 1, n * n % 7 + 1] for n in range(9)
    ]
    found = suggest_mapping([write(tmp_path / "x.csv", rows)])
    said = {
        (str(r[0]), c): r[1:][10 * p : 10 * p + 10] for r in rows[1:] for p, c in enumerate("ab")
    }
    assert answers(found, "sus") == said
    assert answers(found, "own_questions")["K3", "b"] == [3]


def test_a_clock_is_nobody_and_a_player_is_one(tmp_path: Path) -> None:
    rows: list[list[object]] = [["GameTime", "PlayerID", "Level", "EventType", "Payload"]]
    for n in range(1, 7):
        for c in ("Forest", "City"):
            rows += [[float(len(rows)), n, c, "Teleport", "X=1"]]
            rows += [
                [f"{60 * n + 9:.1f}", n, c, f"VRSQ_{item}", answer]
                for item, answer in zip(VRSQ, severity(n, c), strict=True)
            ]
    found = answers(suggest_mapping([write(tmp_path / "log.csv", rows)]), "vrsq")
    assert found == {(str(n), c): severity(n, c) for n in range(1, 7) for c in ("Forest", "City")}


def test_questions_of_answer_events_are_the_items_not_the_event(tmp_path: Path) -> None:
    lines = []
    for n in range(1, 9):
        for c in "AB":
            own = {"pid": f"P{n}", "cond": c}
            lines.append({**own, "event": "start"})
            lines += [
                {**own, "event": "answer", "question": q, "value": draw(n, c, q).randint(1, 7)}
                for q in ("comfort", "presence", "effort")
            ]
    file = tmp_path / "log.jsonl"
    file.write_text("\n".join(map(json.dumps, lines)), encoding="utf-8")
    found = answers(suggest_mapping([file]), "own_questions")
    assert {c for _, c in found} == {"A", "B"}
    assert len(found["P1", "A"]) == 3


def test_a_total_over_all_moments_is_no_answer(tmp_path: Path) -> None:
    head = [f"{t}_{item}" for t in ("pre", "post") for item in VRSQ]
    rows: list[list[object]] = [["id", *head, "SC0"]]
    for n in range(1, 13):
        said = [*severity(n), *severity(n, "post")]
        rows.append([f"P{n}", *said, sum(said)])
    assert 'ignore = ["SC0"]' in suggest_mapping([write(tmp_path / "x.csv", rows)]).text
