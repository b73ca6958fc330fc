"""All that a participant reads is in the protocol's languages: no sentence of the code's own."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

import vrcomfort
from tests.console.test_headset import Events, WornHeadset
from tests.console.test_verbal import Experimenter
from tests.session.test_panel import ScriptedScreen, choose
from tests.support.operator import ScriptedDesk, Wanted
from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.questionnaire import find_instrument
from vrcomfort.respondent import Form, InstructionContent, Withdrew
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_input import Pointing
from vrcomfort.respondent.panel_layout import Act
from vrcomfort.respondent.panel_picture import Painter
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.panel_screen import PanelScreen, words_picture
from vrcomfort.session.verbal import VerbalRespondent

SHOWS = {
    "Page",
    "Cell",
    "InstructionContent",
    "words_picture",
    "rest_on",
    "_rest_on",
    "_show",
    "instruction_page",
}
"""What puts texts before a participant's eyes."""
ELSEWHERE = {"render", "replay", "tradeoff", "report", "exchange", "console/server.py"}
"""Where words of the same names show something else: pages of a browser, pictures of a report."""


def written(node: ast.AST, constants: Mapping[str, str]) -> Iterator[str]:
    """Yield the words that are written down in an expression, or in a constant that it names."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.Name):
        yield constants.get(node.id, "")
    elif isinstance(node, ast.Subscript):  # not the key of what is looked up
        yield from written(node.value, constants)
    elif not isinstance(node, ast.Compare):
        for child in ast.iter_child_nodes(node):
            yield from written(child, constants)


def own_words(source: str) -> list[str]:
    """Return the words of letters that code shows to participants by itself."""
    if not any(f"{name}(" in source for name in SHOWS):
        return []
    tree = ast.parse(source)
    constants = {
        target.id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name) and isinstance(node.value.value, str)
    }
    found = []
    for node in ast.walk(tree):
        name = getattr(node.func, "attr", None) or getattr(node.func, "id", "") if isinstance(
            node, ast.Call) else ""  # fmt: skip
        if name in SHOWS:
            arguments = [*node.args, *(each.value for each in node.keywords)]
            texts = [text for each in arguments for text in written(each, constants)]
            found += [text for text in texts if any(letter.isalpha() for letter in text)]
    return found


def test_the_finder_finds_words_of_the_codes_own():
    assert own_words('screen.rest_on("Please wait")') == ["Please wait"]
    assert own_words('Page("", f"{n} left", ())') == [" left"]
    assert own_words('Page("", words.rest, (), hint="Click")') == ["Click"]
    assert own_words('Cell(box, "–" if a else str(b), Act.ANSWER)') == []
    assert own_words('WAIT = "Please wait"\nself._show(WAIT)') == ["Please wait"]
    assert own_words('screen.rest_on(words["rest"])') == []


def test_no_module_shows_participants_words_that_no_language_has():
    package, found = Path(vrcomfort.__file__).parent, {}
    for file in package.rglob("*.py"):
        relative = file.relative_to(package).as_posix()
        if not {relative, relative.split("/")[0]} & ELSEWHERE:
            found[relative] = own_words(file.read_text(encoding="utf-8"))
    assert len(found) > 200  # the walk finds the package; its modules become fewer as they join
    assert {name: words for name, words in found.items() if words} == {}


def marked() -> Words:
    """Return a language whose every word begins with a mark, placeholders kept."""
    return Words(**{key: f"§{text}"[:30] for key, text in ENGLISH.model_dump().items()
                    if key not in {"place", "hint", "rest_minutes"}},
                 place="§{number}/{count} {instruction}", hint="§{answers}",
                 rest_minutes="§{minutes}")  # fmt: skip


XX = marked()


@pytest.fixture
def drawn(monkeypatch):
    """Return the texts of all pages that are drawn."""
    texts: list[str] = []
    draw = Painter.draw

    def watched(self, page, *more):
        told = [page.content.text] if page.content else []
        texts.extend([page.title, page.question, page.hint, *told])
        texts.extend(cell.text for cell in page.cells if cell.act is not Act.ANSWER)
        return draw(self, page, *more)

    monkeypatch.setattr(Painter, "draw", watched)
    words_picture.cache_clear()
    return texts


def strangers(texts: list[str], known: set[str]) -> set[str]:
    """Return what is neither of the language nor of what is asked."""
    return {text for text in texts if text and text[0] != "§" and text not in known}


def test_a_whole_questionnaire_on_the_panel_is_in_the_participants_language(drawn):
    scale = find_instrument("ssq")
    answers = [choose(Act.ANSWER, 0)] * len(scale.items)
    screen = ScriptedScreen([choose(Act.STOP), choose(Act.BACK), *answers, choose(Act.CONFIRM)])
    person = PanelRespondent(screen, watch=screen.watch, keyboard=True, words=XX)
    person.ask(Form(scale, "post"), lambda *_: None)
    known = {item.text for item in scale.items}
    listed = {text for text in drawn if ": " in text}  # of the list of all answers
    assert len(listed) == len(scale.items)
    assert strangers(drawn, known | listed) == set()
    assert {XX.review, XX.all_correct, XX.sure, XX.go_on, XX.stop_now, XX.back} <= set(drawn)


def test_rests_ratings_instructions_and_stopping_are_in_the_participants_language(drawn):
    rating = find_instrument("fms")
    screen = ScriptedScreen([])
    clock = iter(range(1000))
    person = PanelRespondent(screen, words=XX, now_s=lambda: float(next(clock)))
    person.resting(300.0)
    person.resting(30.0)
    person.read(InstructionContent("a", sound_s=1.0), 0.0, may_go_on=True)
    person.leave()
    person.prompt(rating, 0.0, 10.0)
    for pointing in (Pointing(unable=True), Pointing(unable=True), Pointing(unable=True),
                     Pointing((0.5, 0.5), dwelling=True), Pointing(stop=True)):  # fmt: skip
        screen.do(pointing)
        person.update(1.0)
    assert strangers(drawn, {rating.instruction}) == set()
    wanted = {XX.rest, XX.rest_soon, XX.proceed, XX.listen_sound, XX.no_controller, XX.look_twice}
    assert wanted | {"§5"} <= set(drawn)


def test_what_stands_there_without_a_question_is_in_the_participants_language(drawn):
    screen = PanelScreen(WornHeadset(), words=XX)
    screen.show_loading()
    desk = ScriptedDesk([Wanted("ready", "start"), Wanted("exposure", "pause")],
                        starts_sessions=True)  # fmt: skip
    operators = OperatorControl(desk)
    operators.attach(Events(), screen, words=XX)
    operators.await_start()
    operators.begin("exposure", "exposure 1 of 1")
    for _ in range(5):
        operators.look()
    assert set(drawn) - {""} == {XX.loading, XX.ready, XX.paused}


def test_what_is_asked_aloud_is_told_in_the_participants_language(drawn):
    screen = PanelScreen(WornHeadset(), words=XX)
    desk = Experimenter()
    operators = OperatorControl(desk)
    operators.attach(Events(), screen, words=XX)
    clock = iter(range(10**6))
    person = VerbalRespondent(desk, operators, screen, words=XX, now_s=lambda: float(next(clock)))
    operators.begin("questionnaire", "questionnaire fms (post)")
    person.ask(Form(find_instrument("fms"), "post"), lambda *_: None)
    person.resting(10.0)
    assert set(drawn) - {""} == {XX.listen, XX.rest_aloud}


def test_a_page_of_whoever_leaves_names_nothing_else(drawn):
    screen = ScriptedScreen([choose(Act.STOP), choose(Act.WITHDRAW)])
    person = PanelRespondent(screen, watch=screen.watch, words=XX)
    with pytest.raises(Withdrew):
        person.read(InstructionContent("a", "§Words"), 0.0, may_go_on=True)
    assert strangers(drawn, set()) == set()
