"""Who a person is, and which column is the condition: told by the structure of a table."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from pathlib import Path

import openpyxl
import pytest

from tests.importing.test_layouts import suggested_import
from tests.support.layouts import write
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import Suggestion, suggest_mapping

ITEMS = ("nausea", "headache", "fatigue", "eyestrain", "sweating", "vertigo")
Row = list[object]


def answers(*seed: int) -> list[int]:
    return [(sum(seed) * 7 + k * (k + 3)) % 4 for k in range(len(ITEMS))]


def of(found: Suggestion) -> Imported:
    assert found.imported is not None, found.doubts
    return found.imported


def conditions_of(found: Suggestion) -> dict[str, set[str]]:
    """Return participant → conditions."""
    told: dict[str, set[str]] = {}
    for _, each in of(found).responses:
        told.setdefault(each.participant, set()).add(each.condition)
    return told


def two_labs() -> list[Row]:
    rows: list[Row] = [["lab name", "pid", "video", "age", "gender", "used VR before", *ITEMS]]
    for lab in range(2):
        for n in range(1 + 4 * lab, 17 + 4 * lab):
            person = [20 + (n * 5 + lab * 9) % 23, "fm"[(n + lab) % 2], ["ja", "nein"][n % 2]]
            videos = [f"clip{(n * 3 + lab + k * 5) % 15}.mp4" for k in range(3)]
            rows += [
                [f"Lab{lab + 1}", n, video, *person, *answers(n, k)]
                for k, video in enumerate(videos)
            ]
    return rows


def test_a_code_of_two_labs_is_two_people_and_many_videos_are_scenes(tmp_path: Path) -> None:
    found = suggest_mapping([write(tmp_path / "ssq.csv", two_labs())])
    told = conditions_of(found)
    assert len(told) == 32
    assert "Lab1_16" in told
    assert "Lab2_16" in told
    assert {*of(found).conditions} == {"all"}
    assert len({each.scene for _, each in of(found).responses}) == 15
    asked = " ".join(found.doubts)
    assert "Is a code in 'pid' another person in each 'lab name'?" in asked
    assert "Does 'video' say which of 15 things was shown?" in asked


def test_a_code_whose_person_has_one_age_is_one_person_in_both_conditions(tmp_path: Path) -> None:
    rows = [["display", "id", "age", "gender", *ITEMS]]
    rows += [
        [display, n, 20 + n % 7, "fm"[n % 2], *answers(n, k)]
        for k, display in enumerate(("VR", "screen"))
        for n in range(1, 11)
    ]
    told = conditions_of(suggest_mapping([write(tmp_path / "ssq.csv", rows)]))
    assert told == {str(n): {"VR", "screen"} for n in range(1, 11)}


def test_ratings_under_a_heading_for_facts_make_nobody_another_person(tmp_path: Path) -> None:
    aids = ("cane", "AR", "none")
    rows: list[Row] = [["subject", "trial_type", "vision", *ITEMS]]
    rows += [
        [n, aid, 1 + (n * 3 + k * 2) % 7, *answers(n, k)]
        for n in range(1, 13)
        for k, aid in enumerate(aids)
    ]
    found = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    assert conditions_of(found) == {str(n): {*aids} for n in range(1, 13)}
    judged = [each.answers for name, each in of(found).responses.items() if name[0] != "ssq"]
    assert [[*answers.values()] for answers in judged] == [[row[2]] for row in rows[1:]]


def test_facts_that_another_file_contradicts_are_left_out_and_asked_about(tmp_path: Path) -> None:
    def table(name: str, group: str, *rest: list[object]) -> Path:
        rows: list[Row] = [["subject", "group", name, *rest[0]]]
        rows += [[n, group if n > 6 else "blue", n % 5, *rest[n]] for n in range(1, 13)]
        return write(tmp_path / f"{name}.csv", rows)

    before = table("height", "dim", *([] for _ in range(13)))
    after = table("weight", "dark", [*ITEMS], *(answers(n) for n in range(1, 13)))
    found = suggest_mapping([before, after])
    groups = {code: facts["group"] for code, facts in of(found).participants.items()}
    assert groups == {str(n): "dim" if n > 6 else "blue" for n in range(1, 13)}
    question = "Another file contradicts 'group' of weight.csv: which is right?"
    assert any(question in each for each in found.doubts)


@pytest.mark.parametrize("differ", [True, False])
def test_codes_of_two_files_are_other_people_if_their_ages_differ(
    tmp_path: Path, *, differ: bool
) -> None:
    files = [
        write(
            tmp_path / f"study_{name}.csv",
            [
                ["id", "age", *ITEMS],
                *([f"P{n}", 20 + n % 7 + 9 * k * differ, *answers(n, k)] for n in range(1, 9)),
            ],
        )
        for k, name in enumerate(("vignette", "control"))
    ]
    found = suggest_mapping(files)
    assert len(conditions_of(found)) == (16 if differ else 8)
    assert any("are they the same people?" in each for each in found.doubts) == differ


def test_people_counted_anew_in_each_group_below_the_other_are_others(tmp_path: Path) -> None:
    rows: list[Row] = [["group", "id", *ITEMS]]
    rows += [
        [group, n, *answers(n, k)]
        for k, group in enumerate(("control", "vignette"))
        for n in range(1, 9 + k)
    ]
    found = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    told = conditions_of(found)
    assert told == {
        f"{group}_{n}": {group}
        for k, group in enumerate(("control", "vignette"))
        for n in range(1, 9 + k)
    }


def test_codes_that_begin_anew_in_each_condition_are_asked_about(tmp_path: Path) -> None:
    def asked(order: list[tuple[str, int]]) -> str:
        rows = [[scene, f"P{n:02}", *answers(n, scene == "B")] for scene, n in order]
        found = suggest_mapping([write(tmp_path / "ssq.csv", [["Scene", "Code", *ITEMS], *rows])])
        return found.text if "is 'P01' of 'A' the 'P01' of 'B'?" in " ".join(found.doubts) else ""

    runs = [(scene, n) for scene in "AB" for n in range(1, 13)]
    assert 'participant = { columns = ["Scene", the column of the codes] }' in asked(runs)
    assert not asked(sorted(runs, key=lambda each: each[1]))


@pytest.mark.parametrize("missing", ["fehlend", "n/a", "-99", "keine Angabe"])
def test_a_word_for_missing_is_no_condition_and_who_lacks_rows_is_none(
    missing: str, tmp_path: Path
) -> None:
    rows: list[Row] = [["Code", "Game", "Version", *ITEMS]]
    for n in range(1, 13):
        versions = {"maze": 1 + n % 2, "coaster": 2 - n % 2, "room": missing}
        rows += [
            [f"AB{n:02d}", game, version, *answers(n, k)]
            for k, (game, version) in enumerate(versions.items())
        ]
    rows[5][1] = missing
    found = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    assert {*of(found).conditions} - {""} == {"maze", "coaster", "room"}
    assert any("'Version' lacks rows: is it not the condition?" in each for each in found.doubts)


def test_numbers_that_all_have_equally_often_are_conditions_and_counts_are_none(
    tmp_path: Path,
) -> None:
    def table(*, gain: bool) -> Path:
        rows: list[Row] = [["id", "errors", *(["gain"] if gain else []), *ITEMS]]
        rows += [
            [
                f"P{n}",
                (n * n + k * k * 3) % 4,
                *([10 * (1 + (n + k) % 3)] if gain else []),
                *answers(n, k),
            ]
            for n in range(1, 13)
            for k in range(3)
        ]
        return write(tmp_path / f"ssq_{gain}.csv", rows)

    assert {*of(suggest_mapping([table(gain=True)])).conditions} == {"10", "20", "30"}
    assert {*of(suggest_mapping([table(gain=False)])).conditions} == {"all"}


def test_a_flag_that_differs_in_few_people_is_no_condition(tmp_path: Path) -> None:
    rows: list[Row] = [["id", "wore it", *ITEMS]]
    rows += [
        [f"P{n}", "late" if n + k == 3 else "in time", *answers(n, k)]
        for n in range(1, 10)
        for k in range(2)
    ]
    assert {*of(suggest_mapping([write(tmp_path / "ssq.csv", rows)])).conditions} == {"all"}


def test_files_called_by_words_with_several_people_each_say_the_condition(tmp_path: Path) -> None:
    files = [
        write(
            tmp_path / f"Post study - {name}.csv",
            [
                ["Q1", "Q2", *ITEMS],
                ["What is your name?", "Comments", *ITEMS],
                *([n, f"fine {n}", *answers(n, k)] for n in range(1, 8)),
            ],
        )
        for k, name in enumerate(("NC", "NM", "SY"))
    ]
    told = conditions_of(suggest_mapping(files))
    assert told == {str(n): {"NC", "NM", "SY"} for n in range(1, 8)}


@pytest.mark.parametrize(("names", "people"), [(("a", "b"), 12), (("pre", "post"), 6)])
def test_rows_of_two_files_are_other_people_but_for_those_before_and_after(
    names: tuple[str, str], people: int, tmp_path: Path
) -> None:
    files = [
        write(tmp_path / f"ssq_{name}.csv", [[*ITEMS], *(answers(n, k) for n in range(6))])
        for k, name in enumerate(names)
    ]
    assert len(conditions_of(suggest_mapping(files))) == people


def test_the_only_column_beside_the_answers_of_people_in_rows_says_their_group(
    tmp_path: Path,
) -> None:
    rows: list[Row] = [[*ITEMS, "music"]]
    rows += [[*answers(n), ["yes", "no"][n % 2]] for n in range(13)]
    assert {*of(suggest_mapping([write(tmp_path / "ssq.csv", rows)])).conditions} == {"yes", "no"}


@pytest.mark.parametrize(
    ("headings", "conditions"),
    [
        ([f"discomfort_{c}_t{t}" for c in "ABC" for t in (1, 2, 3)], {"A", "B", "C"}),
        ([f"Q{q}_cond{c}" for c in (1, 2) for q in range(1, 6)], {"1", "2"}),
        ([f"C{c}_Q{q}" for c in (1, 2, 3) for q in range(1, 5)], {"1", "2", "3"}),
        (
            [
                f"{asked}_{pace}_{view}"
                for asked in ("presence", "nausea", "comfort")
                for pace in ("slow", "fast")
                for view in ("tunnel", "open")
            ],
            {"slow_tunnel", "slow_open", "fast_tunnel", "fast_open"},
        ),
    ],
)
def test_conditions_stand_in_the_headings_of_own_questions(
    headings: Sequence[str], conditions: set[str], tmp_path: Path
) -> None:
    rows: list[Row] = [["id", *headings]]
    rows += [[f"P{n}", *(1 + (n * 3 + k * k) % 7 for k in range(len(headings)))] for n in range(12)]
    found = suggest_mapping([write(tmp_path / "wide.csv", rows)])
    assert {*of(found).conditions} == conditions
    assert len(conditions_of(found)) == 12
    assert ("slow/fast and tunnel/open" in found.text) == (len(conditions) == 4)


def test_numbered_columns_say_the_conditions_of_own_questions_with_their_number(
    tmp_path: Path,
) -> None:
    rows: list[Row] = [["ID", *(f"Treatment{n}{w}" for n in (1, 2) for w in ("", "Frustration"))]]
    pair = ("With_Notification", "Without_Notification")
    rows += [[f"X{n}A", pair[n % 2], 1 + n % 5, pair[1 - n % 2], 1 + n * 3 % 5] for n in range(10)]
    found = suggest_mapping([write(tmp_path / "answers.csv", rows)])
    assert conditions_of(found) == {f"X{n}A": {*pair} for n in range(10)}


def test_codes_of_two_workbooks_and_of_two_layouts_are_other_people(tmp_path: Path) -> None:
    layouts: tuple[list[str], list[str]] = ([*ITEMS], [*ITEMS, "Stomach awareness"])
    tables = [
        [
            ["ID", "Age", *items],
            *([f"P{n}", 20 + n + 9 * k, *answers(n, k), *([1] * k)] for n in range(1, 7)),
        ]
        for k, items in enumerate(layouts)
    ]
    texts = [write(tmp_path / f"lab_{k}.csv", rows) for k, rows in enumerate(tables)]
    books = []
    for k in range(2):
        book = openpyxl.Workbook()
        for row in [[*r[:8]] for r in tables[k]]:
            book.worksheets[0].append(row)
        books.append(tmp_path / f"lab_{k}.xlsx")
        book.save(books[-1])
    for files in (texts, books):
        found = suggest_mapping(files)
        assert {*conditions_of(found)} == {f"lab_{k}_P{n}" for k in (0, 1) for n in range(1, 7)}
        assert of(found).participants["lab_1_P3"]["age"] == "32"
        assert any("are they the same people? Assumed: they are not" in d for d in found.doubts)


def test_names_of_files_with_other_columns_each_say_the_moment_and_questions_are_no_groups(
    tmp_path: Path,
) -> None:
    people = range(108, 120)
    before: list[Row] = [["Q1", *ITEMS], *([n, *answers(n)] for n in people)]
    after: list[Row] = [["Q1", *ITEMS, "Q2", "Q3"]]
    after += [[n, *answers(n, 1), "ab"[n % 2], "left" if n < 114 else "right"] for n in people[1:]]
    files = [
        write(tmp_path / "pre_study.csv", before),
        write(tmp_path / "post_study.csv", after),
    ]
    found = of(suggest_mapping(files))
    assert {*found.conditions} == {"all"}
    met = {(each.participant, each.timepoint) for _, each in found.responses}
    assert met == {
        *((str(n), "baseline") for n in people),
        *((str(n), "post") for n in people[1:]),
    }


def test_people_of_a_list_have_other_letters_before_their_numbers(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Participant", "Condition", "Comfort"]]
    rows += [[f"P{n}", c, 1 + (n + k) % 7] for n in range(1, 7) for k, c in enumerate(("VR", "PC"))]
    first = [
        ["Participant", "Started with"],
        *([f"ID{n}", ("VR", "PC")[n % 2]] for n in range(1, 7)),
    ]
    files = [write(tmp_path / "answers.csv", rows), write(tmp_path / "people.csv", first)]
    imported, text = suggested_import(files, tmp_path)
    assert imported.participants["P1"] == {"started_with": "PC"}
    assert len(imported.participants) == 6
    assert "Are these participants one person each: 'P1' and 'ID1'" in text


def test_rows_of_several_files_without_codes_are_other_people(tmp_path: Path) -> None:
    def asked(count: int, *statements: str) -> list[list[object]]:
        answers = ([1 + (n * k) % 5 for k in range(1, 1 + len(statements))] for n in range(count))
        return [list(statements), *answers]

    sites = asked(6, "Le texte était clair.", "Je trouve ce site utile.", "Je me sens à l'aise.")
    needs = asked(8, "Les capacités du site correspondent à mes besoins", "Le site est facile")
    files = [write(tmp_path / "deep.csv", sites), write(tmp_path / "umux.csv", needs)]
    imported, text = suggested_import(files, tmp_path)
    assert "Are rows of deep.csv, umux.csv of other people each" in text
    assert len(imported.participants) == 14
    assert sum(len(each.answers) for each in imported.responses.values()) == 6 * 3 + 8 * 2


def test_a_file_for_each_exposure_has_a_row_without_headings(tmp_path: Path) -> None:
    scenes = ("Calming", "Exciting", "Neutral")
    files = [
        write(
            tmp_path / f"2020-10-{10 + n},0{k}.{n}{k}.csv",
            [[110 * n, f"2020-10-{10 + n}", f"0{k}.{n}{k}", scene, 1 + (n + k) % 9, 9 - n % 9]],
        )
        for n in range(1, 8)
        for k, scene in enumerate(scenes)
    ]
    people = [["How old are you?", "What is your gender?"], *([20 + n, "Female"] for n in range(7))]
    imported, text = suggested_import([*files, write(tmp_path / "people.csv", people)], tmp_path)
    assert imported.conditions == list(scenes)
    assert [*imported.participants] == [str(110 * n) for n in range(1, 8)]
    assert 'ignore_files = ["people.csv"]' in text


def test_columns_for_conditions_that_lack_rows_or_say_them_again_are_no_factors(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [
        ["Participant", "Condition", "Preferred condition", "Condition code", "Location", "Comfort"]
    ]
    cues = ("Control", "HUD", "World")
    rows += [
        [f"P{n}", c, ("", *("Yes", "No")[:: 1 - 2 * (n % 2)])[k], k, 1 + (n + k) % 7, 1 + n * k % 7]
        for n in range(1, 9)
        for k, c in enumerate(cues)
    ]
    imported, _ = suggested_import([write(tmp_path / "cues.csv", rows)], tmp_path)
    assert imported.conditions == list(cues)
    assert {len(each.answers) for each in imported.responses.values()} == {2}


def test_a_column_of_two_numbers_under_a_heading_for_names_tells_no_people_apart(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [["Email", "Presence", "Comfort"]]
    rows += [[n % 2, 1 + n % 7, 1 + (2 * n) % 7] for n in range(1, 13)]
    imported, _ = suggested_import([write(tmp_path / "tools.csv", rows)], tmp_path)
    assert len(imported.participants) == 12


def test_a_code_that_rows_share_is_the_person_where_another_column_numbers_the_rows(
    tmp_path: Path,
) -> None:
    rows: list[Row] = [["CASE", "SERIAL", "REF", "QUESTNNR", *ITEMS]]
    for n, code in enumerate(("XKQ7", "BLM2", "RTW9", "HVD4", "ZPC3", "NGF8")):
        for k, lens in enumerate(("", *"ABC"[n % 3 :], *"ABC"[: n % 3])):
            rows.append([20 + 5 * n + k, code, lens, "nach" if lens else "vor", *answers(n, k)])
    found = suggest_mapping([write(tmp_path / "cases.csv", rows)])
    assert conditions_of(found) == {code: {"", *"ABC"} for code in {str(r[1]) for r in rows[1:]}}
    assert {m.timepoint for _, m in of(found).responses if not m.condition} == {"baseline"}
    assert any("'SERIAL', 'CASE'" in doubt for doubt in found.doubts)


def test_numbers_behind_words_that_say_the_same_are_no_other_answers(tmp_path: Path) -> None:
    words, numbers = (("None", "Slight", "Moderate", "Severe"), range(1, 5))
    names = [f"{item} object-{k} " for k, item in enumerate((*ITEMS, *ITEMS), start=4)]
    ends = ("Response", "Quantised")
    rows: list[Row] = [["ID", "Store: turning", *(name + end for name in names for end in ends)]]
    for n in range(1, 7):
        for k, turning in enumerate(("", "snap", "smooth")):
            said = [each for a in answers(n, k) for each in (words[int(a)], numbers[int(a)])]
            blank = [""] * len(said)
            rows.append([f"P{n}", turning, *(blank + said if turning else said + blank)])
    imported = of(suggest_mapping([write(tmp_path / "forms.csv", rows)]))
    assert {(m.condition, m.timepoint) for _, m in imported.responses} == {
        ("", "baseline"), ("snap", "post"), ("smooth", "post"),
    }  # fmt: skip
    assert len(imported.responses) == 18


def test_moments_stand_before_one_word_of_headings(tmp_path: Path) -> None:
    rows: list[Row] = [
        ["ID", "Lens", *(f"{when}sick_{i}" for when in ("pre", "post") for i in ITEMS)]
    ]
    rows += [
        [f"P{n}", lens, *answers(n, k), *answers(n + 1, k)]
        for n in range(1, 7)
        for k, lens in enumerate("AB")
    ]
    imported = of(suggest_mapping([write(tmp_path / "visits.csv", rows)]))
    assert {(m.condition, m.timepoint) for _, m in imported.responses} == {
        (lens, when) for lens in "AB" for when in ("baseline", "post")
    }


def test_loops_are_conditions_whatever_their_questions_are_filled_with(tmp_path: Path) -> None:
    loops = [f"{n}_{block}_" for n in (1, 2, 3) for block in ("SSQ_post", "TLX")]
    asked = {
        "SSQ_post": ITEMS,
        "TLX": ("Mental Demand", "Physical Demand", "Effort", "Frustration"),
    }
    head, texts = ["PID"], ["Your code"]
    for block in ("SSQ_pre_", *loops):
        items = asked["TLX" if "TLX" in block else "SSQ_post"]
        head += [f"{block}{k}" for k in range(1, len(items) + 1)]
        task = "Before the first: how do you feel?"
        if block in loops:
            task = "You just used it at ${lm://Field/1}. How was it?"
        texts += [f"{task} - {item}" for item in items]
    rows: list[Row] = [[*head], [*texts]]
    rows += [[f"P{n}", *((n * k) % 4 for k in range(1, len(head)))] for n in range(1, 7)]
    file = write(tmp_path / "loops.csv", rows)
    words = tmp_path / "words.toml"
    words.write_text('[conditions]\nwords = ["1", "2", "3"]\n', encoding="utf-8")
    for own in ([], [words]):
        imported = of(suggest_mapping([file], vocabularies=own))
        assert {(m.condition, m.timepoint) for _, m in imported.responses} == {
            ("", "baseline"), ("1", "post"), ("2", "post"), ("3", "post"),
        }  # fmt: skip


def test_remarks_beside_blocks_are_no_conditions_and_forms_number_from_the_second_on(
    tmp_path: Path,
) -> None:
    orders = ["walk → fly → jump", "fly → jump → walk", "jump → walk → fly"]
    remarks = ["nice", "", "too fast", "", "my arms hurt", "nice", ""]
    said = "How was it?"
    head = ["Code", "Order of versions", *ITEMS, said]
    head += [f"{name}{k}" for k in (2, 3) for name in (*ITEMS, said)]
    rows: list[Row] = [[*head]]
    for n in range(9):
        blocks = [[*answers(n, k), remarks[(n + k) % len(remarks)]] for k in range(3)]
        rows.append([f"P{n + 1}", orders[n % 3], *(cell for block in blocks for cell in block)])
    found = suggest_mapping([write(tmp_path / "forms.csv", rows)])
    told = {(m.participant, m.trial): m.condition for _, m in of(found).responses}
    given = {
        (f"P{n + 1}", str(k)): condition
        for n in range(9)
        for k, condition in enumerate(orders[n % 3].split(" → "), start=1)
    }
    assert told == given
    assert any("Order of versions" in doubt for doubt in found.doubts)


def test_the_row_of_texts_below_codes_says_which_column_is_the_person(tmp_path: Path) -> None:
    """The order in which blocks were drawn is shared by people who differ in the rest."""
    drawn = [*map("|".join, permutations(["FL_1", "FL_2", "FL_3", "FL_4"]))]
    often = ["Regularly", "A few times", "Once or twice", "Never"]
    codes = ["Status", "Q1", "Q4", "FL_12_DO", *(f"Q6_{k}" for k in range(1, 7))]
    texts = ["Response Type", "Participant number (given by the experimenter)"]
    texts += ["How often have you used a VR headset before?", "Block Randomizer - Display Order"]
    rows: list[Row] = [[*codes], [*texts, *(f"How do you feel? - {item}" for item in ITEMS)]]
    for n, (order, before) in enumerate(zip("ABCDEFFGHIEHGI", "AABCDADCDDBDBB", strict=True)):
        person = ["IP Address", n + 1, often["ABCD".index(before)], drawn["ABCDEFGHI".index(order)]]
        felt = ("None", "Slight", "Moderate", "Severe")
        rows.append([*person, *(felt[answer] for answer in answers(n))])
    found = suggest_mapping([write(tmp_path / "survey.csv", rows)])
    assert [*conditions_of(found)] == [str(n) for n in range(1, 15)]


def test_what_people_are_asked_of_themselves_is_no_condition(tmp_path: Path) -> None:
    degrees = ["Bachelor"] * 5 + ["Master"] * 2 + ["PhD"]
    rows: list[Row] = [["Timestamp", "What is your highest degree at present?", *ITEMS]]
    rows += [[f"2024-03-02 10:{n:02}", degrees[n % 8], *answers(n)] for n in range(24)]
    assert of(suggest_mapping([write(tmp_path / "form.csv", rows)])).conditions == ["all"]


def test_a_group_that_people_are_asked_for_is_the_condition(tmp_path: Path) -> None:
    for heading in ("What is your group?", "Which version were you assigned to?"):
        rows: list[Row] = [["Participant number", heading, *ITEMS]]
        rows += [[n, ("red", "blue")[n % 2], *answers(n)] for n in range(20)]
        found = of(suggest_mapping([write(tmp_path / "form.csv", rows)]))
        assert {*found.conditions} == {"red", "blue"}, heading


def test_a_code_that_people_are_asked_for_tells_them_apart(tmp_path: Path) -> None:
    rows: list[Row] = [["Enter the code you were given", "How old are you?", *ITEMS]]
    rows += [[f"K{n}Q", 20 + n, *answers(n)] for n in range(12)]
    found = of(suggest_mapping([write(tmp_path / "form.csv", rows)]))
    assert [*found.participants] == [f"K{n}Q" for n in range(12)]


def test_what_people_ranked_is_not_the_condition_of_numbered_questions(tmp_path: Path) -> None:
    rows: list[Row] = [["ID", "Q1", "Q2", "Q3", "Rank1", "Rank2", "Rank3"]]
    orders = [*permutations(["teleport", "walk", "fly"])]
    rows += [[n, 1 + n % 7, 1 + n * 3 % 7, 1 + n * 5 % 7, *orders[n * n % 5]] for n in range(20)]
    found = suggest_mapping([write(tmp_path / "answers.csv", rows)])
    assert "beside" not in found.text


def test_a_statement_about_what_was_shown_is_no_experience_of_people(tmp_path: Path) -> None:
    heads = ["Participant", "I found it engaging", "It was a creative experience"]
    rows = [heads, *([f"P{n}", n % 5, n * 3 % 5] for n in range(40))]
    found = of(suggest_mapping([write(tmp_path / "post.csv", rows)]))
    given = [r.answers for r in found.responses.values()]
    assert sum("it_was_a_creative_experience" in each for each in given) == 40


def test_a_row_of_a_grid_is_no_condition_whatever_the_grid_asks(tmp_path: Path) -> None:
    tight = ["Too tight", "Tight", "Clear"]
    heads = ["ID", *(f"Answer below for the following conditions.{each}" for each in tight)]
    heads += ["I found it engaging"]
    rows = [[f"P{n}", "3.0x+", "2.0x", ("1.0x", "<1.0x")[n % 2], 1 + n % 5] for n in range(12)]
    found = of(suggest_mapping([write(tmp_path / "form.csv", [heads, *rows])]))
    assert found.conditions == ["all"]


def test_conditions_of_two_files_that_differ_in_case_are_one_and_asked_about(
    tmp_path: Path,
) -> None:
    people = [f"P{p}" for p in range(1, 11)]
    head = [f"{item}_{c}" for c in ("Shop", "Fake") for item in ITEMS]
    asked = [[p, *answers(n), *answers(n, 1)] for n, p in enumerate(people)]
    shown = [(n, p, c) for n, p in enumerate(people) for c in ("shop", "fake")]
    timed = [[p, c, 3000 + (17 * n if c == "shop" else -9 * n)] for n, p, c in shown]
    files = [
        write(tmp_path / "asked.csv", [["ID", *head], *asked]),
        write(tmp_path / "timed.csv", [["ID", "condition", "clicks made"], *timed]),
    ]
    found = suggest_mapping(files)
    assert {*of(found).conditions} == {"Shop", "Fake"}
    assert "Are these conditions, spelt in two ways, the same: 'Shop' and 'shop'" in found.text
