"""`vrcomfort new`: what it writes passes `check`, and what it cannot write is one sentence."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

from vrcomfort.cli import new as command
from vrcomfort.cli.app import app
from vrcomfort.design import build_design
from vrcomfort.design.audit import cannot_balance
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.draft import high_answer
from vrcomfort.questionnaire import find_instrument
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene


def new(*words: str):
    return CliRunner().invoke(app, ["new", *words])


ONE, TWO = ["temple"], ["temple", "mountain"]


@pytest.mark.parametrize(
    ("compare", "rating", "scenes"),
    [
        ("depth_of_field", "fms", ONE),
        ("motion_blur", "misc", TWO),
        ("both", "none", ONE),
        ("both", "misc", TWO),
        ("each", "fms", TWO),
        ("each", "none", ONE),
    ],
)
def test_whatever_is_chosen_is_a_protocol_that_balances(tmp_path, compare, rating, scenes):
    file = tmp_path / "study.toml"
    chosen = [word for scene in scenes for word in ("--scene", scene)]
    told = ["--compare", compare, "--rating", rating, "--participants", "5", "--yes"]
    result = new(str(file), *chosen, *told)
    assert result.exit_code == 0, result.output
    protocol = load_protocol(file)
    assert protocol.name == "study"
    assert protocol.scenes == tuple(scenes)
    assert protocol.participants is not None
    assert protocol.participants >= 5
    assert cannot_balance(build_design(protocol), protocol.participants) is None
    assert [each.instrument for each in protocol.ratings] == [rating] * (rating != "none")
    effects = {(bool(c.depth_of_field), bool(c.motion_blur)) for c in protocol.conditions}
    assert (False, False) in effects
    assert len(effects) == {"both": 4, "each": 3}.get(compare, 2)


def test_options_stand_in_the_file_and_every_table_has_a_comment(tmp_path):
    file = tmp_path / "study.toml"
    title = 'Ein "Titel" für alle'
    new(
        str(file), "--title", title, "--exposure-min", "2.5", "--sessions", "2", "--participants",
        "4", "--language", "de", "--language", "en", "--yes",
    )  # fmt: skip
    protocol = load_protocol(file)
    assert (protocol.title, protocol.exposure_s) == (title, 150.0)
    assert (protocol.order.sessions, protocol.break_s) == (2, 0.0)
    assert protocol.languages == ("de", "en")
    lines = file.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines):
        if line.startswith(("[order]", "[simulation]", "languages")):
            assert lines[number - 1].startswith("#")


def test_three_conditions_over_two_days_with_sixteen_people(tmp_path):
    """Both days show all three; 16 people cannot balance six orders, which is said or meant."""
    days = ("--compare", "each", "--sessions", "2", "--participants", "16", "--rating", "fms")
    more, meant = tmp_path / "more.toml", tmp_path / "meant.toml"
    told = new(str(more), *days, "--yes")
    assert "16 participants would not balance the orders; it plans 18" in told.stderr
    assert (
        "3 exposures do not divide over 2 sessions; each session shows all of them" in told.stderr
    )
    assert load_protocol(more).participants == 18
    assert new(str(meant), *days, "--unbalanced", "--yes").exit_code == 0
    for file, allowed in ((more, False), (meant, True)):
        protocol = load_protocol(file)
        assert (protocol.order.unbalanced, protocol.participants) == (
            allowed,
            16 if allowed else 18,
        )
        assert [each.every_s for each in protocol.ratings] == [60.0]
        for person in build_design(protocol).plan(16):
            assert [len({trial.condition for trial in day}) for day in person.sessions] == [3, 3]
        checked = CliRunner().invoke(app, ["check", str(file), "--no-draw"])
        assert checked.exit_code == 0, checked.output


def test_balanced_numbers_are_not_called_unbalanced(tmp_path):
    file = tmp_path / "study.toml"
    assert new(str(file), "--participants", "16", "--unbalanced", "--yes").exit_code == 0
    assert not load_protocol(file).order.unbalanced


@pytest.mark.parametrize("minutes", [0.4, 0.5, 2.5, 60])
def test_ratings_come_at_times_at_which_people_can_answer_them(tmp_path, minutes):
    file = tmp_path / "study.toml"
    told = new(str(file), "--exposure-min", str(minutes), "--rating", "fms", "--yes")
    assert told.exit_code == 0, told.output
    protocol = load_protocol(file)
    assert ("have no time for ratings" in told.stderr) == (not protocol.ratings) == (minutes < 0.5)
    for each in protocol.ratings:
        assert each.timeout_s >= 10
        assert each.every_s >= 2 * each.timeout_s
        assert each.due_times(protocol.exposure_s, np.random.default_rng(0))


def test_it_passes_check_with_its_rehearsal(tmp_path):
    file = tmp_path / "study.toml"
    new(str(file), "--participants", "4", "--exposure-min", "1", "--language", "de", "--yes")
    result = CliRunner().invoke(app, ["check", str(file), "--no-draw"])
    assert result.exit_code == 0, result.output
    assert "nothing is wrong" in result.output


def test_questions_are_asked_again_until_the_answer_can_be(tmp_path, monkeypatch):
    answers = iter(
        ["blur", "motion_blur", "moon", "mountain", "no", "0", "12", "A name", "", "2", "", "misc"]
    )
    asked = []

    def answer(question):
        asked.append(question)
        return next(answers, "")

    monkeypatch.setattr("builtins.input", answer)
    monkeypatch.setattr(command, "somebody_answers", lambda: True)
    file = tmp_path / "asked.toml"
    command.new(file)
    protocol = load_protocol(file)
    assert asked[0].startswith("What is compared with no effect (depth_of_field, ")
    assert protocol.conditions[1].motion_blur is not None
    assert (protocol.scenes, protocol.participants) == (("mountain",), 12)
    assert (protocol.title, protocol.exposure_s) == ("A name", 600.0)
    assert (protocol.order.sessions, protocol.ratings[0].instrument) == (2, "misc")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["there.toml"], "is there already; choose another name"),
        (["no/where/study"], "there is no such folder"),
        (["my study"], "cannot be called 'my study'"),
        (["moon", "--scene", "moon"], "there is no scene `moon`"),
        (["czech", "--language", "cs"], "`cs` lacks words of the panel"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(tmp_path, words, told):
    (tmp_path / "there.toml").write_text("kept", encoding="utf-8")
    name, *options = words
    result = new(str(tmp_path / name), *options, "--yes")
    assert isinstance(result.exception, InputError)
    found = [result.exception, *result.exception.others]
    assert any(told in str(each) for each in found)
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]
    assert (tmp_path / "there.toml").read_text(encoding="utf-8") == "kept"


@pytest.mark.smoke
def test_ratings_that_end_exposures_are_on_their_scales():
    for name, high in (("fms", 15), ("misc", 7)):
        assert high_answer(find_instrument(name)) == high


OWN_QUESTION = """
name = "mine"
title = "My question"
instruction = "How do you feel?"
answers = { low = 0, high = 4 }
[[items]]
name = "ill"
text = "Ill"
"""


def test_conditions_of_any_effects_own_questions_days_and_breaks(tmp_path):
    (tmp_path / "mine.toml").write_text(OWN_QUESTION, "utf-8")
    file, own = tmp_path / "study.toml", str(tmp_path / "mine.toml")
    compared = ["vignette.restricted_deg=40", "speed_blur", "relocation_blur",
                "depth_of_field+vignette.colour=scene"]  # fmt: skip
    words = [word for each in compared for word in ("--compare", each)]
    told = new(
        str(file), *words, "--questionnaire", "vrsq", "--questionnaire", own, "--rating", own,
        "--sessions", "5", "--break-s", "90", "--exposure-s", "120", "-n", "10", "--yes",
    )  # fmt: skip
    assert told.exit_code == 0, told.output
    protocol = load_protocol(file)
    assert [each.name for each in protocol.conditions] == [
        "off", "vignette_restricted_deg_40", "speed_blur", "relocation_blur",
        "depth_of_field_vignette_colour_scene",
    ]  # fmt: skip
    assert protocol.conditions[0].label == "No effect"
    assert protocol.conditions[1].vignette.restricted_deg == 40
    assert protocol.conditions[4].vignette.colour == "scene"
    assert protocol.conditions[4].depth_of_field is not None
    assert [each.instrument for each in protocol.questionnaires] == ["vrsq"] * 2 + ["mine"] * 2
    assert (protocol.ratings[0].instrument, protocol.ratings[0].stop_at) == ("mine", 3)
    assert (protocol.order.sessions, protocol.break_s, protocol.exposure_s) == (5, 0.0, 120.0)
    assert protocol.stop.score_rise == ()
    checked = CliRunner().invoke(app, ["check", str(file), "--no-draw"])
    assert checked.exit_code == 0, checked.output
    assert "never narrows the view" not in checked.output


def test_a_scene_of_ones_own_gets_a_side_car_with_its_start(tmp_path):
    scene = tmp_path / "hall.glb"
    scene.write_bytes((data_folder("scenes") / "temple.glb").read_bytes())
    before = load_scene(str(scene))
    folder = tmp_path / "protocols"
    folder.mkdir()
    file = folder / "study.toml"
    told = new(str(file), "--from", str(scene), "-n", "4", "--exposure-s", "60", "--yes")
    assert told.exit_code == 0, told.output
    assert load_protocol(file).scenes == ("../hall.glb",)
    after = load_scene(str(scene))
    assert after.spawn.position == pytest.approx(before.spawn.position, abs=5e-4)
    assert len(after.walkable) == len(before.walkable)
    assert repr(after.environment) == repr(before.environment)
    side_car = tmp_path / "hall.toml"
    text = side_car.read_text("utf-8").replace("exposure = 1 ", "exposure = 2 ")
    side_car.write_text(text, "utf-8")
    again = new(str(folder / "other.toml"), "--from", str(scene), "-n", "4", "--yes")
    assert again.exit_code == 0, again.output
    assert side_car.read_text("utf-8") == text, "an own side-car stays"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--compare", "vignet"], "there is no effect `vignet`; did you mean `vignette`"),
        (["--compare", "vignette.restricted_deg"], "a setting is EFFECT.SETTING=VALUE"),
        (["--compare", "vignette", "--compare", "vignette"], "gives `vignette` twice"),
        (["--compare", "both", "--compare", "vignette"], "leave the others away"),
        (["--compare", "vignette.restricted=3"], "restricted"),
        (["--questionnaire", "sssq"], "sssq"),
        (["--from", "nowhere.glb"], "nowhere.glb"),
    ],
)
def test_what_new_does_not_know_is_one_sentence_and_leaves_nothing(tmp_path, words, told):
    result = new(str(tmp_path / "study"), *words, "--yes")
    assert isinstance(result.exception, InputError), result.output
    assert told in " ".join(str(each) for each in (result.exception, *result.exception.others))
    assert list(tmp_path.iterdir()) == []
