"""Layouts as labs have published them, with made numbers: each was met in a public repository.

Conditions beside their block, orders of conditions, blocks by position, words that only some names
of files have, totals and physiology beside items, moments glued to other words.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from tests.support.layouts import (
    CONDITIONS,
    ENGLISH,
    GERMAN,
    ITEMS,
    PEOPLE,
    WORDS,
    Truth,
    study,
    write,
)

Made = tuple[list[Path], Truth]
BILINGUAL = ("None / Inexistente", "Mild / Leve", "Moderate / Moderado", "Severe / Severo")


def with_baseline(conditions: Sequence[str] = CONDITIONS) -> Truth:
    """Return answers before everything, of no condition, and after each condition."""
    before = {
        (who, "", "baseline"): a for (who, _, _), a in study(("x",), ("baseline",), 3).items()
    }
    return {**before, **study(conditions, ("post",))}


def scene_and_sums(folder: Path) -> Made:
    """The condition under Scene; sums and scores between and after the items."""
    truth = study(("2D", "3D"), ("post",))
    items = [f"{n}\n{text}" for n, text in enumerate(ENGLISH, start=1)]
    sums = ["Sum1", "Nausea", "sum2", "Oculomotor", "sum3", "Disorientation", "SSQ Total Score"]
    rows: list[Sequence[object]] = [["Scene", "Participant Number", *items, *sums]]
    for (person, condition, _), a in truth.items():
        n = a[0] + a[5] + a[6] + a[7] + a[8] + a[14] + a[15]
        o = a[0] + a[1] + a[2] + a[3] + a[4] + a[8] + a[10]
        d = a[4] + a[7] + a[9] + a[10] + a[11] + a[12] + a[13]
        scores = [n, round(n * 9.54, 2), o, round(o * 7.58, 2), d, round(d * 13.92, 2)]
        rows.append([condition, person, *a, *scores, round((n + o + d) * 3.74, 2)])
    return [write(folder / "SSQ.csv", rows)], truth


def long_of_several(folder: Path) -> Made:
    """A row per answer, of two questionnaires, and scores among them; many different values."""
    truth = study(("2D Label", "3D Ghost"), ("post",))
    load = ["Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort"]
    rows: list[Sequence[object]] = [["Scene", "Participant", "variable", "value"]]
    for place, ((person, condition, _), answers) in enumerate(truth.items()):
        said = [("Completion Time", 60 + place * 7.13)]
        said += [(name, 5 + (place + n) % 90) for n, name in enumerate([*load, "Frustration"])]
        said += [*zip(ENGLISH, answers, strict=True), ("Sum1", sum(answers)), ("SSQ Score", 1.5)]
        rows += [[condition, person, name, value] for name, value in said]
    return [write(folder / "data_long_format.csv", rows)], truth


def blocks_without_headings(folder: Path) -> Made:
    """No headings: a baseline and blocks of answers in two languages, the condition before each."""
    truth = with_baseline()
    rows: list[Sequence[object]] = []
    for place, person in enumerate(PEOPLE):
        order = CONDITIONS if place % 2 else CONDITIONS[::-1]
        row: list[object] = [f"03/01/2025 12:{place:02d}:26", person, "No / Não"]
        row += [BILINGUAL[answer] for answer in truth[person, "", "baseline"]]
        for condition in order:
            row += [condition, "Yes / Sim" if place % 3 else "No / Não"]
            row += [BILINGUAL[answer] for answer in truth[person, condition, "post"]]
            row += ["Yes, I'm ready / Sim, estou pronto(a)"]
        rows.append(row)
    return [write(folder / "ssq.csv", rows)], truth


def optional_words_in_names(folder: Path) -> Made:
    """A file each, without headings; the names of some have PRESURVEY, of some STAND."""
    truth = study(("STAND", "without_STAND"))
    files = []
    for (person, condition, time), answers in truth.items():
        name = f"P{int(person[1:]):03d}_360VIDEO_VIVE_ACR_SSQ"
        name += "_PRESURVEY" if time == "baseline" else ""
        name += "_STAND" if condition == "STAND" else ""
        rows = [
            [20190918, 150326504 + 1871 * n, 10144 + 1871 * n, text, answer]
            for n, (text, answer) in enumerate(zip(ENGLISH, answers, strict=True))
        ]
        files.append(write(folder / f"{name}.csv", rows))
    return files, {(f"P{int(who[1:]):03d}", *rest): a for (who, *rest), a in truth.items()}


def numbers_of_a_survey_tool(folder: Path) -> Made:
    """SQ01_01 and the like, 1 to 4, among other numbered questionnaires; one MODE for all."""
    truth = study(("01", "03"), ("post",))
    head = ["CASE", "QUESTNNR", "MODE", "STARTED"]
    head += [f"SQ{condition}_{n:02d}" for condition in ("01", "03") for n in range(1, 17)]
    head += [f"EB01_{n:02d}" for n in range(1, 5)] + ["TIME001", "FINISHED"]
    rows: list[Sequence[object]] = [head]
    for place, person in enumerate(PEOPLE):
        answers = [a + 1 for c in ("01", "03") for a in truth[person, c, "post"]]
        more = [1 + (place + n) % 5 for n in range(4)]
        rows.append([person, "base", "interview", "2021-11-23", *answers, *more, 82 + place, 1])
    return [write(folder / "data_questionnaires.csv", rows)], truth


def said_twice(folder: Path) -> Made:
    """The answers in their order, and again by condition; codes of missing people."""
    truth = with_baseline()
    names = [f"{block}_cs{n}" for block in ("baseline", "loco1", "loco2") for n in range(1, 17)]
    head = ["lfdn", "id", "age", *names, "VP_access_Code", "session_id"]
    head += [f"{condition}_cs{n}" for condition in CONDITIONS for n in range(1, 17)]
    rows: list[Sequence[object]] = [head]
    for place, person in enumerate(PEOPLE):
        order = CONDITIONS if place % 2 else CONDITIONS[::-1]
        met = [truth[person, "", "baseline"], *(truth[person, c, "post"] for c in order)]
        again = [truth[person, c, "post"] for c in CONDITIONS]
        row: list[object] = [place + 7, person, 20 + place, *(a + 1 for each in met for a in each)]
        row += ["-66", f"ac582e8e18d72c4b73c82596{place:04d}"]
        rows.append([*row, *(a + 1 for each in again for a in each)])
    return [write(folder / "data_BA.csv", rows)], truth


def glued_moments(folder: Path) -> Made:
    """``ss_qprae1v1``: the moment inside a word, the condition at the end; means in a last row."""
    truth = study(("1", "2"))
    blocks = [(when, c) for c in ("v1", "v2") for when in ("prae", "post")]
    head = ["datenschutz", "code", "geschlecht", "temp_v1"]
    head += [f"ss_q{when}{n}{c}" for when, c in blocks for n in range(1, 17)]
    head += [f"misc{minute}min_{c}" for c in ("v1", "v2") for minute in (2, 4, 6, 8)]
    rows: list[Sequence[object]] = [[*head, "misc_mean_v1"]]
    for place, person in enumerate(PEOPLE):
        row: list[object] = [1, person, "mw"[place % 2], 21 + place / 10]
        for when, condition in blocks:
            time = "baseline" if when == "prae" else "post"
            row += truth[person, condition[1], time]
        rows.append([*row, *((place + n) % 5 for n in range(8)), "0,17"])
    rows.append(["", "", "", "", *["0,0317"] * (len(head) - 4), "0,24"])
    return [write(folder / "sample_export.csv", rows)], truth


def order_in_each_row(folder: Path) -> Made:
    """A crossover: the order of the conditions in a column, the blocks numbered."""
    truth = study(("A", "B"), ("post",))
    head = ["ID", "Order", *(f"SSQ{n}_{item}" for n in (1, 2) for item in ITEMS)]
    rows: list[Sequence[object]] = [head]
    for place, person in enumerate(PEOPLE):
        order = "AB" if place % 2 else "BA"
        rows.append([person, order, *(a for c in order for a in truth[person, c, "post"])])
    return [write(folder / "crossover.csv", rows)], truth


def asked_before_each_block(folder: Path) -> Made:
    """A form that asks for the condition before each of two blocks with the same headings."""
    truth = study(times=("post",))
    ask = "What did you see?"
    rows: list[Sequence[object]] = [["Zeitstempel", "Code", ask, *ENGLISH, ask, *ENGLISH]]
    for place, person in enumerate(PEOPLE):
        row: list[object] = [f"2024/05/01 10:{place:02d}", person]
        for condition in CONDITIONS if place % 2 else CONDITIONS[::-1]:
            row += [condition, *(WORDS[a] for a in truth[person, condition, "post"])]
        rows.append(row)
    return [write(folder / "Antworten.csv", rows)], truth


def row_numbers(folder: Path) -> Made:
    """A column of row numbers without a heading, as R writes it; people under a strange name."""
    truth = study(times=("post",))
    rows: list[Sequence[object]] = [["", "who", "condition", *ITEMS]]
    for number, ((person, condition, _), answers) in enumerate(truth.items(), start=1):
        rows.append([number, person, condition, *answers])
    return [write(folder / "exported.csv", rows)], truth


def physiology_beside_items(folder: Path) -> Made:
    """Totals called TS, heart rate, skin conductance and a temperature beside the items."""
    truth = study(times=("post",))
    more = ["TS", "First_HR", "OverallHR", "OverallGSR", "temp", "ReactionTime"]
    rows: list[Sequence[object]] = [["Participant", "Condition", *ITEMS, *more]]
    for place, ((person, condition, _), answers) in enumerate(truth.items()):
        body = [sum(answers), 80 + place / 7, 81 + place / 3, 1 + place / 9, 21.5, 0.2 + place / 99]
        rows.append([person, condition, *answers, *body])
    return [write(folder / "all_measures.csv", rows)], truth


def german_and_english(folder: Path) -> Made:
    """German and English in one sheet: headings, answers and the condition."""
    truth = study(times=("post",))
    both = [GERMAN[n] if n % 2 else ENGLISH[n] for n in range(16)]
    words = ("keine", "slight", "mittel", "severe")
    rows: list[Sequence[object]] = [["VP-Nr", "Bedingung", "Age", *both, "Summe"]]
    for (person, condition, _), answers in truth.items():
        said = [words[answer] for answer in answers]
        rows.append([person, condition, 20 + int(person[1:]), *said, sum(answers)])
    return [write(folder / "gemischt.csv", rows, separator=";")], truth


def before_and_after_in_names(folder: Path) -> Made:
    """A file before and one after, of which one condition is called Baseline."""
    truth = study(("Baseline", "StaticSmall", "StaticLarge"))
    files = []
    for name, time in (("PreSSQ", "baseline"), ("PostSSQ", "post")):
        rows: list[Sequence[object]] = [["Name", "Participant", "Session", "Condition", *ENGLISH]]
        sessions: dict[str, int] = {}
        for (person, condition, when), answers in truth.items():
            if when == time:
                sessions[person] = sessions.get(person, 0) + 1
                rows.append(["", person, sessions[person], condition, *answers])
        files.append(write(folder / f"{name}.csv", rows))
    return files, truth


def order_beside_conditions(folder: Path) -> Made:
    """The order of conditions in a column whose heading says condition, too."""
    truth = study(("HED", "HIP", "STF"), ("post",))
    head = ["Timestamp", "Participant ID", "VR motion used ask researcher", "orderCondition"]
    rows: list[Sequence[object]] = [[*head, *ENGLISH, "I found the interface easy to use"]]
    orders: dict[str, int] = {}
    for (person, condition, _), answers in truth.items():
        orders[person] = orders.get(person, 0) + 1
        when = f"25-4-2023 16:{orders[person]:02d}"
        rows.append([when, person, condition, orders[person], *answers, 5])
    return [write(folder / "UXdata.csv", rows, separator=";")], truth


def moments_with_units(folder: Path) -> Made:
    """Three moments in suffixes, one of them so many minutes later."""
    truth = study(("all",), ("baseline", "post", "recovery"))
    moments = ("pre", "post", "30min")
    rows: list[Sequence[object]] = [["VP", *(f"{i}_{m}" for m in moments for i in ENGLISH)]]
    for person in PEOPLE:
        whens = ("baseline", "post", "recovery")
        rows.append([person, *(a for when in whens for a in truth[person, "all", when])])
    return [write(folder / "moments.csv", rows)], truth


def words_under_block(folder: Path) -> Made:
    """Two words under Block are the conditions; three numbered moments in headings."""
    truth = study(("RL", "VR"), ("baseline", "post", "recovery"))
    names = [f"SSQ_T{when}_{n}" for when in range(3) for n in range(1, 17)]
    rows: list[Sequence[object]] = [["VP", "Block", *names]]
    for person in PEOPLE:
        for block in ("RL", "VR"):
            whens = ("baseline", "post", "recovery")
            rows.append([person, block, *(a for w in whens for a in truth[person, block, w])])
    return [write(folder / "blocks.csv", rows)], truth


LAB_LAYOUTS: dict[str, Callable[[Path], Made]] = {
    each.__name__: each
    for each in (
        scene_and_sums, long_of_several, blocks_without_headings, optional_words_in_names,
        numbers_of_a_survey_tool, said_twice, glued_moments, order_in_each_row,
        asked_before_each_block, row_numbers, physiology_beside_items, german_and_english,
        before_and_after_in_names, order_beside_conditions, moments_with_units, words_under_block,
    )
}  # fmt: skip
