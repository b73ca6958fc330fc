"""Several rating schedules at once: times, jitter, missed codes, and what their stop rules end."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.support.session import run
from tests.support.study import (
    PROTOCOL,
    AheadHeadset,
    LateFocus,
    Scripted,
    read_rows,
    tiny_protocol,
)
from vrcomfort.errors import InputError
from vrcomfort.protocol import Ratings
from vrcomfort.records import read_participants, session_folder


def with_ratings(*tables: str) -> str:
    return PROTOCOL.partition("[ratings]")[0] + "".join(f"[[ratings]]\n{each}\n" for each in tables)


class Rater(Scripted):
    """Rates each instrument by a list of answers, the last one again and again; None: nothing."""

    def __init__(self, **answers: list[int | None]) -> None:
        super().__init__()
        self.answers = answers
        self.asked: list[str] = []

    def prompt(self, instrument, elapsed_s, _timeout_s):
        self.asked_s = elapsed_s
        self.asked.append(instrument.name)
        given = self.answers[instrument.name]
        self.rates = given.pop(0) if len(given) > 1 else given[0]

    def rating(self, elapsed_s):
        late = self.rates is not None and elapsed_s >= self.asked_s + 0.5
        return self.rates if late else None


def session(tmp_path, respondent, *tables: str, seed: int = 0, participant: str = "P01"):
    protocol = tiny_protocol(tmp_path, with_ratings(*tables))
    outcome = run(
        protocol,
        participant,
        study=tmp_path / "S",
        seed=seed,
        sessions=[1],
        load_scene=lambda _: None,
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
        respondent=respondent,
    )
    folder = session_folder(tmp_path / "S", participant, 1)
    return outcome, {
        name: read_rows(folder / f"{name}.csv") for name in ("trials", "ratings", "events")
    }


FMS = 'instrument = "fms"\nevery_s = 3.0\ntimeout_s = 2.0'
MISC = 'instrument = "misc"\nevery_s = 3.0\ntimeout_s = 1.0\nmissed_code = 99'


def first_trial(rows):
    began = float(rows["trials"][0]["start_s"])
    return [
        (
            each["instrument"],
            round(float(each["onset_s"]) - began, 3),
            each["response"],
            each["missed"],
        )
        for each in rows["ratings"]
        if each["trial"] == "1"
    ]


def test_of_two_that_are_due_the_second_waits_for_the_first(tmp_path):
    _, rows = session(tmp_path, Rater(fms=[3], misc=[None]), FMS, MISC)
    asked = first_trial(rows)
    assert [(who, response, missed) for who, _, response, missed in asked] == [
        ("fms", "3", "0"),
        ("misc", "", "99"),
        ("fms", "3", "0"),
        ("misc", "", "99"),
        ("misc", "", "99"),
    ]
    onsets = [onset for _, onset, _, _ in asked]
    assert onsets[0] == pytest.approx(3.0, abs=0.11)
    assert onsets[1] == pytest.approx(3.6, abs=0.21)  # half a second's answer later
    assert onsets[4] == pytest.approx(9.0, abs=0.11)  # 9 + 2 s would be too late for the other


def test_jitter_is_drawn_from_the_seed_within_its_limits_and_told(tmp_path):
    jittered = f"{FMS}\njitter_s = 1.0"
    found = []
    for folder, seed in (("a", 1), ("b", 1), ("c", 2)):
        (tmp_path / folder).mkdir()
        _, rows = session(tmp_path / folder, Rater(fms=[3]), jittered, seed=seed)
        found.append(first_trial(rows))
        (told, other) = [e["detail"] for e in rows["events"] if e["name"] == "ratings_planned"]
        assert told != other  # each exposure draws its own
        planned = [float(number) for number in re.findall(r"[\d.]+(?=[, ])", told)]
        assert [onset for _, onset, _, _ in found[-1]] == [
            pytest.approx(due, abs=0.11) for due in planned
        ]
        for n, due in enumerate(planned, start=1):
            assert 3.0 * n - 1.0 <= due <= 3.0 * n + 1.0
    assert found[0] == found[1] != found[2]


def test_questions_that_jitter_are_due_at_whole_milliseconds():
    ratings = Ratings(instrument="fms", every_s=3.0, timeout_s=2.0, jitter_s=1.0)
    due_ms = np.array(ratings.due_times(90.0, np.random.default_rng(0))) * 1000
    np.testing.assert_allclose(due_ms, due_ms.round(), atol=1e-6)
    assert {*(due_ms.round() % 10)} > {0.0}


def test_a_rule_of_two_in_a_row_ends_the_exposure_alone(tmp_path):
    often = FMS.replace("3.0", "1.0").replace("2.0", "0.9")
    rule = f'{often}\nstop_at = 10\nstop_in_a_row = 2\nstop_ends = "exposure"'
    outcome, rows = session(tmp_path, Rater(fms=[12, 5, None, 12, None, 11, 0]), rule)
    assert outcome.status == "enrolled"  # one of two sessions
    first, second = rows["trials"]
    assert (first["status"], first["abort_code"]) == ("completed", "rating")
    lasted = float(first["end_s"]) - float(first["start_s"])
    assert 5.0 < lasted < 8.0
    assert (second["status"], second["abort_code"]) == ("completed", "")
    (told,) = [e["detail"] for e in rows["events"] if e["name"] == "exposure_ended"]
    assert told == "fms 11 reached the limit 10 2 times in a row"


def test_a_rule_may_end_the_study(tmp_path):
    outcome, rows = session(tmp_path, Rater(fms=[12]), f"{FMS}\nstop_at = 10")
    assert outcome.status == "withdrawn"
    assert [(row["status"], row["abort_code"]) for row in rows["trials"]] == [("stopped", "rating")]
    (person,) = read_participants(tmp_path / "S")
    assert person.status == "withdrawn"


def test_a_single_table_of_an_earlier_protocol_is_understood_and_its_faults_have_their_line(
    tmp_path,
):
    assert tiny_protocol(tmp_path).ratings[0].stop_at == 15
    wrong = PROTOCOL.replace("every_s = 3.0", "every_min = 3.0")
    with pytest.raises(InputError, match="use `every_s`") as caught:
        tiny_protocol(tmp_path, wrong)
    assert wrong.splitlines()[caught.value.line - 1] == "every_min = 3.0"


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        ((f"{FMS}\njitter_s = 1.6",), "`jitter_s` is more than half of `every_s`"),
        ((f"{FMS}\nstop_in_a_row = 2",), "`stop_in_a_row` does nothing without `stop_at`"),
        ((FMS, FMS), "`fms` is there twice"),
        ((FMS, MISC.replace("misc", "ssq")), "the SSQ has 16 items; a rating is one question"),
        ((FMS, f"{MISC}\nstop_at = 11"), "the MISC goes from 0 to 10"),
    ],
)
def test_schedules_that_cannot_be_are_refused(tmp_path, tables, told):
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, with_ratings(*tables))
    assert any(told in str(each) for each in (caught.value, *caught.value.others))


def test_simulate_says_that_ratings_of_shortened_exposures_come_at_other_times(run, tmp_path):
    told = "their ratings come at shortened times"
    whole = ("simulate", "smoke", "-n", 1, "--no-draw")
    assert told not in run(*whole, "--out", tmp_path / "whole")[2]
    assert told in run(*whole, "--exposure-s", 0.05, "--out", tmp_path / "shortened")[2]
