"""Layouts of other labs: repeated questions, codes of conditions, names of files, other people."""

from __future__ import annotations

from pathlib import Path

import openpyxl

from tests.importing.test_own_questions import answers, imported_from
from tests.importing.test_wordings import STATEMENTS
from tests.support.layouts import ENGLISH, PEOPLE, write
from vrcomfort.importing.suggest import suggest_mapping

EASY = ["I found it easy to move the robot", "I found it easy to see the details"]


def test_questions_that_repeat_under_one_heading_are_of_as_many_conditions(tmp_path: Path) -> None:
    head = ["Age", "How much fun was it?", *EASY * 3, "Which mode do you like best?"]
    rows = [
        [
            20 + 3 * n % 17,
            n % 3,
            *[1 + (n + k) % 5 for k in range(4)],
            5,
            1 + n % 4,
            "UI" if n % 2 else "Lab",
        ]
        for n in range(10)
    ]
    imported = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert {*imported.conditions} == {"1", "2", "3"}
    third = {
        k: v
        for k, v in answers(imported, "i_found_it_easy_to_move_the_robot").items()
        if k[1] == "3"
    }
    assert [*third.values()] == [5] * 10  # all gave one answer to it, and it is still there


def test_one_question_that_repeats_under_its_heading_is_of_as_many_conditions(
    tmp_path: Path,
) -> None:
    rows = [[20 + n, *[1 + (n * k + k) % 5 for k in range(1, 4)]] for n in range(10)]
    imported = imported_from(write(tmp_path / "x.csv", [["Age", *EASY[:1] * 3], *rows]))
    assert {*imported.conditions} == {"1", "2", "3"}


def test_codes_before_the_same_numbers_are_conditions_where_a_column_has_their_order(
    tmp_path: Path,
) -> None:
    head = ["ID", "Order", *(f"{code}_{n}" for code in ("PnP", "HMD") for n in range(1, 5))]
    rows = [[p, 1 + n % 2, *[(n + k) % 8 for k in range(8)]] for n, p in enumerate(PEOPLE)]
    file = write(tmp_path / "x.csv", [head, *rows])
    found = suggest_mapping([file])
    assert found.imported is not None
    assert {*found.imported.conditions} == {"Pn_P", "HMD"}
    assert any("in headings of the same questions" in doubt for doubt in found.doubts)
    assert answers(found.imported, "question_2")["P03", "HMD", "post"] == (2 + 5) % 8


def test_names_of_files_that_no_one_word_tells_apart_say_conditions_in_two(tmp_path: Path) -> None:
    files = []
    for place, name in enumerate(("360_stereo", "360_mono", "cgi_stereo")):
        for end, more in (("", 0), ("_post", 1)):
            rows = [
                [p, *[min(3, more + (n + k + place) % 3) for k in range(16)]]
                for n, p in enumerate(PEOPLE)
            ]
            files.append(
                write(
                    tmp_path / f"{name}{end}_info.csv",
                    [["ID", *ENGLISH][: 17 - more], *(r[: 17 - more] for r in rows)],
                )
            )
    imported = imported_from(*files)
    assert {*imported.conditions} == {"360_stereo", "360_mono", "cgi_stereo"}
    # What is called as the answers after exposure are, but for that word, is from before.
    assert {m.timepoint for _, m in imported.responses} == {"baseline", "post"}
    assert answers(imported, "general_discomfort")["P02", "360_mono", "baseline"] == 2


def test_names_that_recur_from_file_to_file_are_people_and_files_conditions(tmp_path: Path) -> None:
    files = [
        write(
            tmp_path / f"{name}_speed.csv",
            [
                ["name", "WPM"],
                *(
                    [who, 5 + n * 1.3 + k]
                    for n, who in enumerate(("cx", "cyl", "dyh", "fjy", "lhz"))
                ),
            ],
        )
        for k, name in enumerate(("Fan", "Fan+Cross", "Split"))
    ]
    imported = imported_from(*files)
    assert {*imported.conditions} == {"Fan", "Fan+Cross", "Split"}
    assert len(imported.participants) == 5
    assert "cyl" not in imported.participants


def test_participants_who_are_counted_at_the_top_stand_side_by_side(tmp_path: Path) -> None:
    files = []
    for place, name in enumerate(("2D", "3D")):
        rows: list[list[object]] = [["ID", *range(1, 9)]]
        rows += [
            [f"errors{word}", *((n * k + place * n) % 4 for n in range(1, 9))]
            for k, word in enumerate(("A", "B", "C"), 1)
        ]
        files.append(write(tmp_path / f"map_{name}.csv", rows))
    imported = imported_from(*files)
    assert {*imported.participants} == {str(n) for n in range(1, 9)}
    assert answers(imported, "errors_b")["3", "2D", "post"] == 2


def asked(*files: tuple[Path, str, list[str]]) -> list[Path]:
    """Write files with a row for each answer, and the person twice."""
    head = ["participant_id", "section", "index", "question", "answer", "pp"]
    return [
        write(
            folder / f"{name}_raw.csv",
            [
                head,
                *(
                    [
                        p,
                        f"{name}-{k % 2}",
                        k,
                        text,
                        ("7-strongly agree", "6", "5", "2")[(n + k) % 4],
                        p,
                    ]
                    for n, p in enumerate(PEOPLE)
                    for k, text in enumerate(texts)
                ),
            ],
        )
        for folder, name, texts in files
    ]


def test_files_with_other_questions_in_rows_are_no_conditions(tmp_path: Path) -> None:
    one = [
        f"I can use artificial intelligence for my {what}"
        for what in ("work", "home", "goals", "art")
    ]
    two = [
        f"I would rather make my own decisions about my {what}"
        for what in ("work", "home", "goals", "art")
    ]
    found = suggest_mapping(asked((tmp_path, "ai", one), (tmp_path, "doc", two)))
    assert found.imported is not None
    assert {*found.imported.conditions} == {"all"}  # nor are sections, of which each has a part
    assert not any("Which of the columns" in doubt for doubt in found.doubts)
    values = {a for r in found.imported.responses.values() for a in r.answers.values()}
    assert values == {7, 6, 5, 2}


def test_numbered_sentences_are_no_items_of_a_questionnaire_of_as_many(tmp_path: Path) -> None:
    rows = [
        [k, f"{k}. I felt that I controlled part {k} of the virtual body", 1 + (n + k) % 7, p]
        for n, p in enumerate(PEOPLE)
        for k in range(1, 17)
    ]
    file = write(tmp_path / "x.csv", [["index", "question_text", "answer_index", "pp"], *rows])
    imported = imported_from(file)
    assert {instrument for instrument, _ in imported.responses} == {"own_questions"}
    assert len({i for r in imported.responses.values() for i in r.answers}) == 16


def test_a_person_who_answers_one_condition_twice_is_asked_about(tmp_path: Path) -> None:
    rows = [[p, c, 1 + (n + k) % 5] for n, p in enumerate(PEOPLE) for c in "ab" for k in range(2)]
    found = suggest_mapping([write(tmp_path / "x.csv", [["ID", "Condition", "comfort"], *rows])])
    assert found.imported is not None
    assert len(found.imported.responses) == 40


def test_one_file_that_is_refused_with_other_columns_leaves_them_in_the_others(
    tmp_path: Path,
) -> None:
    pen = [
        ["ID", "Condition", "depth"],
        *([p, c, 3.25 * n + k] for n, p in enumerate(PEOPLE) for k, c in enumerate("ab")),
    ]
    torn = [
        ["ID", "Condition", "width"],
        *([p, c, 2.75 * n] for n, p in enumerate(PEOPLE) for c in "ab"),
    ]
    torn.append(["P01", "a", 1.0e7])
    files = [write(tmp_path / "one.csv", pen), write(tmp_path / "two.csv", torn)]
    imported = imported_from(*files)
    assert answers(imported, "depth")["P02", "b", "post"] == 4.25


def test_rows_that_a_column_calls_first_are_baselines_wherever_they_stand(tmp_path: Path) -> None:
    head = ["ID", "is_first_response", "type", *ENGLISH]
    rows = [
        [p, flag, kind, *[(n + k) % 4 for k in range(16)]]
        for n, p in enumerate(PEOPLE)
        for flag, kind in (("No", "DLC"), ("No", "MLC"), ("Yes", ""))
    ]
    imported = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    said = {(m.condition, m.timepoint) for _, m in imported.responses}
    assert said == {("DLC", "post"), ("MLC", "post"), ("", "baseline")}


def test_names_in_sheets_are_people_where_statistics_stand_in_other_sheets(tmp_path: Path) -> None:
    names = ("cx", "cyl", "dyh", "fjy", "lhz")
    files = [
        write(
            tmp_path / f"{pad}_speed.csv",
            [["name", "WPM"], *([w, 5.5 + n + k] for n, w in enumerate(names))],
        )
        for k, pad in enumerate(("Fan", "Split"))
    ]
    files.append(
        write(
            tmp_path / "statistics.csv", [["source", "SS", "df"], ["rows", "x", 1], ["all", "y", 1]]
        )
    )
    imported = imported_from(*files)
    assert {*imported.conditions} == {"Fan", "Split"}
    assert len(imported.participants) == 5


def test_knowledge_before_and_after_is_of_two_moments_and_of_no_condition(tmp_path: Path) -> None:
    """No word tells conditions apart, and what all know after the exposure is kept."""
    codes = ["att_1", "att_1", "att_2", "not_sec_1", "not_sec_2", "not_sec_3"]
    pre, post = ([f"{when}_{code}" for code in codes] for when in ("pre", "post"))
    head = [*pre, *post[1:], "post_ease1", "post_ease2", "points"]
    rows = [[*[(n // 3 + k) % 2 for k in range(6)], 1] for n in range(12)]
    rows = [
        [*row, n % 2, (n + 1) % 2, 1, 1, 1 + n % 5, 5 - n % 4, n - 1] for n, row in enumerate(rows)
    ]
    rows[4][6:-1] = [0, 0, 1, 0, 0, "", ""]  # the only one who does not know, and rates nothing
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    assert {*found.imported.conditions} == {"all"}
    assert {when for *_, when in answers(found.imported, "not_sec_3")} == {"baseline", "post"}
    assert [*answers(found.imported, "att_1").values()].count(1) > len(rows)
    assert any("'-1' among numbers stand for no answer" in doubt for doubt in found.doubts)


def test_a_third_row_of_headings_and_recoded_answers_beside_are_no_answers(tmp_path: Path) -> None:
    raw = [[1 + (3 * n + k * k) % 5 for k in range(10)] for n in range(10)]
    recoded = [[5 - v if k % 2 else v - 1 for k, v in enumerate(row)] for row in raw]
    rows = [
        ["As answered", *[""] * 9, "", "Computed", *[""] * 9, "", "Sums", ""],
        [*STATEMENTS, "", *STATEMENTS, "", "odd", "even"],
        [f"The same of our game, {k % 11}" if k % 11 < 10 else "" for k in range(24)],
        *(
            [*one, "", *two, "", sum(two[::2]), sum(two[1::2])]
            for one, two in zip(raw, recoded, strict=True)
        ),
    ]
    found = suggest_mapping([write(tmp_path / "SUS.csv", rows)])
    assert found.imported is not None
    assert [*answers(found.imported, "sus_2").values()] == [row[1] for row in raw]
    assert any("row 3 say the headings in other words" in doubt for doubt in found.doubts)


def test_columns_that_hold_the_same_films_in_other_orders_say_the_condition(tmp_path: Path) -> None:
    films = ["461", "779", "880"]
    head = ["ID", *(h for n in (1, 2, 3) for h in (f"film{n}", f"{n}_end_time", f"{n}_liking"))]
    rows = [
        [p, *(v for k in range(3) for v in (films[(n + k) % 3], 20.5 + n + k, 1 + (n + 2 * k) % 5))]
        for n, p in enumerate(PEOPLE)
    ]
    imported = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert {*imported.conditions} == {*films}
    assert answers(imported, "liking")["P02", "880", "post"] == 1 + (1 + 2) % 5


def test_things_ranked_in_words_are_conditions_and_the_order_of_the_words_is_asked(
    tmp_path: Path,
) -> None:
    said = [("Least easy", "In between", "Most easy"), ("Least fun", "In between", "The funniest")]
    things = ("Wand", "Gaze", "Voice")
    asked = ("Rank them by ease", "Rank them by fun")
    head = ["ID", *(f"{text} [{thing}]" for text in asked for thing in things)]
    rows = [
        [p, *(words[(n * (k + 1) + t) % 3] for k, words in enumerate(said) for t in range(3))]
        for n, p in enumerate(PEOPLE)
    ]
    found = suggest_mapping([write(tmp_path / "ranks.csv", [head, *rows])])
    assert found.imported is not None
    assert {*found.imported.conditions} == {*things}
    order = "'Least fun' < 'In between' < 'The funniest'"
    assert any("order do these ranks stand" in each and order in each for each in found.doubts)
    ranks = answers(found.imported, "rank_them_by_fun")
    assert [ranks[PEOPLE[0], thing, "post"] for thing in things] == [1, 2, 3]


def test_numbered_words_that_no_scale_knows_are_no_symptoms(tmp_path: Path) -> None:
    head = ["ID", *(f"{n}_liking" for n in range(1, 17)), "How realistic was it?"]
    rows = [[p, *["aime", "aime_pas"] * 8, 1 + n % 5] for n, p in enumerate(PEOPLE)]
    imported = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert {instrument for instrument, _ in imported.responses} == {"own_questions"}


def test_yes_and_no_to_what_one_felt_are_answers_of_each_file(tmp_path: Path) -> None:
    files = [
        write(
            tmp_path / f"subjective_{name}.csv",
            [
                ["Id", f"I felt safe with the {name} feedback", "How realistic?", "How pleasant?"],
                *[
                    [n, "Yes" if (n + place) % 3 else "No", 1 + n % 5, 1 + (n + place) % 5]
                    for n in range(1, 9)
                ],
            ],
        )
        for place, name in enumerate(("sound", "visual"))
    ]
    imported = imported_from(*files)
    assert {*imported.conditions} == {"sound", "visual"}
    felt = answers(imported, "i_felt_safe_with_the_visual_feedback")
    assert felt == {(str(n), "visual", "post"): int((n + 1) % 3 > 0) for n in range(1, 9)}


def test_runs_of_headings_under_the_names_of_conditions_stand_above_their_means(
    tmp_path: Path,
) -> None:
    values = {"Rift": [1, 4, 5, 2, 2, 3], "Wall": [3, 3, 1, 4, 5, 5]}
    head = ["Display", "Realism", "Ease"]
    rows: list[list[object]] = [
        [c for name, given in values.items() for c in (name if n < 5 else "", given[n], 1 + n % 5)]
        for n in range(6)
    ]
    means = [sum(given) / 6 for given in values.values()]
    below = ["", means[0], 2.66666667, "", means[1], 2.66666667]
    spread = ["", 1.47, 1.5, "", 1.51, 1.5]
    file = write(tmp_path / "x.csv", [head * 2, *rows, below, spread])
    imported = imported_from(file)
    found = answers(imported, "realism")
    assert {c: [v for (_, d, _), v in found.items() if d == c] for c in values} == values


def test_the_doubt_about_rows_of_means_says_how_to_read_them(tmp_path: Path) -> None:
    given = [[n % 5, n * 3 % 7] for n in range(11)]
    rows = [[f"P{n}", *each] for n, each in enumerate(given)]
    means = ["", *(round(sum(each) / 11, 2) for each in zip(*given, strict=True))]
    found = suggest_mapping([write(tmp_path / "x.csv", [["", "Nausea", "Fatigue"], *rows, means])])
    assert "Are rows from 13 on means" in found.text
    assert 'instead = "in `read`: skip_rows = []"' in found.text


def test_numbered_words_of_agreement_are_no_symptoms(tmp_path: Path) -> None:
    words = ["Strongly disagree", "Somewhat disagree", "Somewhat agree", "Strongly agree"]
    head = ["ID", *(f"TRUST_{n}" for n in range(1, 17))]
    rows = [[p, *(words[(n + k) % 4] for k in range(16))] for n, p in enumerate(PEOPLE)]
    imported = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert {instrument for instrument, _ in imported.responses} == {"trust"}


def test_words_of_one_degree_are_answers_to_two_questions(tmp_path: Path) -> None:
    head = ["ID", "How high was the effort?", "How high was the strain?"]
    rows = [
        [p, ("Low effort", "High effort")[n % 2], ("High strain", "Low strain")[n // 2 % 2]]
        for n, p in enumerate(PEOPLE)
    ]
    assert suggest_mapping([write(tmp_path / "x.csv", [head, *rows])]).imported is not None


def test_numbers_that_each_scene_has_are_levels_and_no_outcomes(tmp_path: Path) -> None:
    head = ["participant", "scenario", "lateral", "clearance", "How safe was it?"]
    rows = [
        [p, s, [0.5, 0.5, 1.5][s - 1], 0.8 + (n + s) * 0.1, 1 + (n + s) % 5]
        for n, p in enumerate(PEOPLE)
        for s in ((n, n + 1, n + 2)[: 2 + n % 2])
        for s in (1 + s % 3,)
    ]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    items = {item for r in found.imported.responses.values() for item in r.answers}
    assert items == {"clearance", "how_safe_was_it"}
    assert "'lateral'" in found.text


def test_a_rating_of_sessions_is_no_number_of_a_session(tmp_path: Path) -> None:
    head = ["Participant", "designSession", "How useful was the seminar?"]
    rows = [[p, 5 + n % 4, 3 + n % 7] for n, p in enumerate(PEOPLE)]
    imported = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert answers(imported, "design_session")["P02", "all", "post"] == 6


def test_a_sheet_of_one_row_is_no_table(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["ID", "How realistic was it?"])  # type: ignore[union-attr]
    for n, p in enumerate(PEOPLE):
        book.active.append([p, 1 + n % 5])  # type: ignore[union-attr]
    book.create_sheet("legend").append(["Legend", "1 = not at all, 5 = very"])
    book.save(tmp_path / "x.xlsx")
    imported = imported_from(tmp_path / "x.xlsx")
    assert len(imported.participants) == len(PEOPLE)


def test_an_id_of_what_was_shown_is_no_outcome(tmp_path: Path) -> None:
    head = ["participant", "Display", "QuestionID", "Trust"]
    rows = [
        [p, d, 4 + (n * 3 + k) % 11, 1 + (n + k) % 5]
        for n, p in enumerate(PEOPLE)
        for k, d in enumerate(("Rift", "Wall"))
    ]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert "May 'QuestionID' be left out" in found.text
    assert found.imported is not None
    assert {i for r in found.imported.responses.values() for i in r.answers} == {"trust"}
