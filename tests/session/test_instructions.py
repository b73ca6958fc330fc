"""Instructions: told as text, picture and sound; recorded, checked, and told again on resuming."""

from __future__ import annotations

import struct
import sys
import time
import wave
import zlib
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from tests.session.test_panel import ScriptedScreen, choose
from tests.support import resume
from tests.support.operator import Given, ScriptedDesk
from tests.support.resume import manifest, rows
from tests.support.study import PROTOCOL, Scripted, tiny_protocol
from vrcomfort.api.simulation import simulate_sessions
from vrcomfort.cli.check import _check
from vrcomfort.cli.session_devices import open_speaker
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.headset.sound import SilentSpeaker, Sound, SystemSpeaker, read_sound
from vrcomfort.protocol import load_protocol
from vrcomfort.respondent import (
    InstructionContent,
    SimulatedRespondent,
    TerminalRespondent,
    Withdrew,
)
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_layout import FOOT_TOP_PX, MARGIN_PX, SIZE_PX, Act
from vrcomfort.respondent.panel_picture import TEXT, Painter, instruction_page
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.session.instructor import instruction_faults
from vrcomfort.session.operator_control import OperatorControl

go = partial(resume.go, exposure_s=1.0)

WELCOME = """
[[instructions]]
name = "welcome"
when = "session_start"
text = "Welcome to the study."
picture = "way.png"
sound = "welcome.wav"
"""
SECOND = """
[[instructions]]
name = "second"
when = "before_trial"
trials = [2]
text = "Now the same once more."
min_s = 2.0
"""
THANKS = """
[[instructions]]
name = "thanks"
when = "session_end"
text = "Thank you."
max_s = 4.0
"""


def write_wav(file: Path, duration_s: float = 1.5, rate_hz: int = 8000) -> None:
    with wave.open(str(file), "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(rate_hz)
        out.writeframes(b"\1\2" * round(duration_s * rate_hz))


def media(folder: Path) -> None:
    Image.new("RGB", (200, 100), (250, 0, 0)).save(folder / "way.png")
    write_wav(folder / "welcome.wav")


def told(folder: Path, more: str = WELCOME + SECOND + THANKS, head: str = ""):
    media(folder)
    return tiny_protocol(folder, head + PROTOCOL + more)


def told_again(folder: Path):
    """Return the protocol with the files as they are now."""
    return tiny_protocol(folder, PROTOCOL + WELCOME)


def events(tmp_path: Path, name: str = "instruction") -> list[tuple[float, str]]:
    found = [row for row in rows(tmp_path, "events") if row["name"] == name]
    return [(float(row["duration_s"]), row["detail"]) for row in found]


@pytest.mark.smoke
def test_what_was_told_and_how_long_is_recorded(tmp_path):
    person = Scripted()
    go(tmp_path, person, protocol=told(tmp_path), speaker=SilentSpeaker())
    first, second, last = events(tmp_path)
    assert first[0] == pytest.approx(1.5)  # nobody goes on before the sound is over
    assert first[1] == (
        "welcome: text, picture way.png, sound welcome.wav, 1.5 of 1.5 s; ended by participant"
    )
    assert second == (pytest.approx(2.0), "second: text; ended by participant")
    assert last == (0.0, "thanks: text; ended by participant")
    assert person.told[0].picture is not None
    assert person.told[0].picture.shape == (100, 200, 4)
    assert not verify_study(tmp_path / "S").faults
    assert {each["name"] for each in rows(tmp_path, "events")} >= {"instruction", "session_end"}
    assert set(manifest(tmp_path)["protocol"]["media"]) == {"way.png", "welcome.wav"}


def test_without_a_sound_device_the_text_stands_in(tmp_path):
    text = WELCOME.replace("sound =", 'show_text = "without_sound"\nsound =')
    person = Scripted()
    go(tmp_path, person, protocol=told(tmp_path, text), speaker=None)
    assert person.told[0].text == "Welcome to the study."
    assert "sound welcome.wav not played: no sound device" in events(tmp_path)[0][1]
    person = Scripted()
    go(tmp_path, person, protocol=told(tmp_path, text), speaker=SilentSpeaker(), study="H")
    assert person.told[0].text == ""
    assert person.told[0].sound_s == pytest.approx(1.5)


def test_an_instruction_goes_on_by_itself_after_its_longest_time(tmp_path):
    class Dreaming(Scripted):
        def read(self, *_, **_more):
            return 0.3

    go(tmp_path, Dreaming(), protocol=told(tmp_path, THANKS))
    assert events(tmp_path) == [(pytest.approx(4.0), "thanks: text; ended by time")]


def test_simulated_participants_read_and_hear_without_frames(tmp_path):
    protocol = told(tmp_path)
    person = SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    go(
        tmp_path, person, protocol=protocol, speaker=SilentSpeaker(), jumps=True,
        headset_for=lambda *_: StillHeadset(), renderer=NoPictures(),
    )  # fmt: skip
    durations = [each for each, _ in events(tmp_path)]
    words = 4 * 0.3 + 5.0
    assert durations == pytest.approx([words, 2.0, 2 * 0.3])
    plain = SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    go(
        tmp_path, plain, protocol=tiny_protocol(tmp_path), study="plain", jumps=True,
        headset_for=lambda *_: StillHeadset(), renderer=NoPictures(),
    )  # fmt: skip
    said = (tmp_path / "plain/sub-P01/ses-1/questionnaires.csv").read_text().splitlines()
    with_told = [row["response"] for row in rows(tmp_path, "questionnaires")]
    assert with_told == [line.split(",")[9] for line in said[1:]]  # nobody answers otherwise


def test_the_experimenter_may_cut_it_short_and_repeat_it(tmp_path):
    class Desk(ScriptedDesk):
        given = 0

        def next_command(self):
            step = self.steps[-1]
            if step.kind != "instruction" or self.given == 2:
                return None
            self.given += 1
            return Given("redo" if self.given == 1 else "skip", step.number, "A", "")

    class Waiting(Scripted):
        def read(self, *_, **_more):
            return 0.1

    desk = Desk()
    go(tmp_path, Waiting(), protocol=told(tmp_path, THANKS), operators=OperatorControl(desk))
    assert [detail.rpartition("ended by ")[2] for _, detail in events(tmp_path)] == [
        "redone",
        "experimenter",
    ]
    assert desk.steps[-1].words == "instruction thanks: Thank you."


def test_an_interrupted_instruction_is_told_again_on_resuming(tmp_path):
    class Interrupted(Scripted):
        def read(self, content, elapsed_s, *, may_go_on):
            if content.name == "second":
                raise KeyboardInterrupt
            return super().read(content, elapsed_s, may_go_on=may_go_on)

    protocol = told(tmp_path)
    assert go(tmp_path, Interrupted(), protocol=protocol).status == "aborted"
    assert events(tmp_path)[-1][1] == "second: text; ended by interruption"
    person = Scripted()
    assert go(tmp_path, person, protocol=protocol, resume=True).status == "enrolled"
    named = [each.name for each in person.told]
    assert list(dict.fromkeys(named)) == ["welcome", "second", "thanks"]
    assert [row["status"] for row in rows(tmp_path, "trials")] == ["completed", "completed"]
    assert not verify_study(tmp_path / "S").faults


def test_a_session_is_not_resumed_with_another_picture(tmp_path):
    class Interrupted(Scripted):
        def ask(self, *_):
            raise KeyboardInterrupt

    protocol = told(tmp_path)
    go(tmp_path, Interrupted(), protocol=protocol)
    Image.new("RGB", (10, 10)).save(tmp_path / "way.png")
    with pytest.raises(InputError, match=r"begun with another way\.png; resume it with the same"):
        go(tmp_path, Scripted(), protocol=protocol, resume=True)


def test_somebody_may_withdraw_while_being_told(tmp_path):
    class Leaving(Scripted):
        def read(self, *_, **_more):
            raise Withdrew("had enough of words")

    assert go(tmp_path, Leaving(), protocol=told(tmp_path)).status == "withdrawn"
    assert not verify_study(tmp_path / "S").faults


GERMAN = """
[text.de.instructions.welcome]
text = "Willkommen."
sound = "welcome.wav"
[text.de.instructions.second]
text = "Und noch einmal."
[text.de.instructions.thanks]
text = "Danke."
"""
BOTH = 'languages = ["en", "de"]\n'


def test_instructions_have_languages(tmp_path):
    protocol = told(tmp_path, WELCOME + SECOND + THANKS + GERMAN, BOTH)
    assert [each.text for each in protocol.spoken("de").told] == [
        "Willkommen.",
        "Und noch einmal.",
        "Danke.",
    ]
    assert protocol.spoken("de").told[0].picture == "way.png"  # that of the usual language
    assert protocol.spoken("en").told[0].text == "Welcome to the study."


@pytest.mark.parametrize(
    ("more", "head", "says"),
    [
        (WELCOME.replace("way.png", "lost.png"), "", "there is no picture file"),
        (WELCOME.replace("welcome.wav", "lost.wav"), "", "there is no sound file"),
        ('[[instructions]]\nname = "a"\nwhen = "session_end"\n', "", "`a` tells nothing"),
        (THANKS.replace("max_s", "min_s = 9.0\nmax_s"), "", "`max_s` is less than `min_s`"),
        (THANKS + "trials = [1]\n", "", "`trials` does nothing with when"),
        (THANKS + 'show_text = "without_sound"\n', "", "needs a `text` and a `sound`"),
        (WELCOME.replace("way.png", "w" * 300), "", "picture"),
        (THANKS + THANKS, "", "`thanks` is there twice"),
        (WELCOME, BOTH, "instruction `welcome` lacks its text and its sound in `de`"),
        (GERMAN, BOTH, "there is no instruction `welcome`"),
        (THANKS + GERMAN.replace("de", "en"), BOTH, "`en` is the usual language"),
    ],
)
def test_what_cannot_be_told_is_refused(tmp_path, more, head, says):
    with pytest.raises(InputError) as caught:
        told(tmp_path, more, head)
    assert any(says in str(each) for each in (caught.value.alone, *caught.value.others))


def faults(folder: Path) -> str:
    return " ".join(map(str, instruction_faults(tiny_protocol(folder, PROTOCOL + WELCOME))))


def test_files_that_cannot_be_used_are_found_before_anybody_comes(tmp_path):
    media(tmp_path)
    assert faults(tmp_path) == ""
    (tmp_path / "way.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    assert "way.png: this picture cannot be shown" in faults(tmp_path)
    Image.new("RGB", (200, 900)).save(tmp_path / "way.png")
    assert "200 x 900 pixels, and the panel has room for 944 x" in faults(tmp_path)
    large = bytearray((tmp_path / "way.png").read_bytes())
    large[16:24] = struct.pack(">II", 30_000, 12_000)  # twice what Pillow takes
    large[29:33] = struct.pack(">I", zlib.crc32(large[12:29]))
    (tmp_path / "way.png").write_bytes(large)
    assert "far larger than the panel" in faults(tmp_path)
    Image.new("RGB", (200, 100)).save(tmp_path / "way.png", format="GIF")
    assert "save it as PNG or JPEG" in faults(tmp_path)
    media(tmp_path)
    whole = (tmp_path / "welcome.wav").read_bytes()
    for broken, says in (
        (whole[:-200], "cut off"),
        (b"", "this sound cannot be played"),
        (b"RIFF" + bytes(40), "this sound cannot be played"),
    ):
        (tmp_path / "welcome.wav").write_bytes(broken)
        assert says in faults(tmp_path)
    write_wav(tmp_path / "welcome.wav", 700.0, 100)
    assert "lasts 11.7 minutes, and instructions at most 10" in faults(tmp_path)


def test_no_damaged_file_ends_in_a_traceback(tmp_path):
    for cut in (*range(0, 60, 7), 200):
        media(tmp_path)
        for name in ("way.png", "welcome.wav"):
            content = bytearray((tmp_path / name).read_bytes())
            content[cut] ^= 0xFF
            (tmp_path / name).write_bytes(content)
        faults(tmp_path)  # whatever it finds, it is told


def test_check_tells_of_a_text_that_does_not_fit(tmp_path):
    told(tmp_path, THANKS.replace("Thank you.", "many words " * 150))
    found = _check(str(tmp_path / "tiny.toml"), None, None, 2, False, lambda *_: None)
    (fault,) = found.faults
    assert "the text of instruction `thanks` does not fit on the panel" in str(fault)


def test_the_panel_shows_the_picture_as_it_is_and_a_button_once_one_may_go_on():
    picture = np.zeros((120, 300, 4), dtype=np.uint8)
    picture[...] = 10, 200, 30, 255
    content = InstructionContent("a", "Look at this.", picture)
    drawn = Painter().draw(instruction_page(content, ready=False), None)
    green = (drawn == picture[0, 0]).all(axis=2)
    assert green.sum() == 120 * 300
    rows_, columns = np.nonzero(green)
    assert columns.min() + columns.max() + 1 == 1024  # in the middle
    assert (drawn[: rows_.min()] == np.array(TEXT)).all(axis=2).any()  # words above it
    many = Painter().draw(instruction_page(InstructionContent("a", "i " * 600), ready=False), None)
    _, columns = np.nonzero((many[:FOOT_TOP_PX] == np.array(TEXT)).all(axis=2))
    assert MARGIN_PX <= columns.min() < MARGIN_PX + 20  # words have the width between the margins
    assert SIZE_PX[0] - MARGIN_PX - 20 < columns.max() < SIZE_PX[0] - MARGIN_PX
    pages = []
    screen = ScriptedScreen([choose(Act.CONFIRM)])
    person = PanelRespondent(screen, watch=lambda page: (pages.append(page), screen.watch(page)))
    assert person.read(content, 0.0, may_go_on=False) == 0.0
    assert pages == []
    assert person.read(content, 1.0, may_go_on=True) is None
    person.leave()
    assert screen.pictures[-1] is None


def test_stopping_at_an_instruction_is_asked_twice():
    screen = ScriptedScreen([choose(Act.STOP), choose(Act.WITHDRAW)])
    person = PanelRespondent(screen, watch=screen.watch)
    with pytest.raises(Withdrew):
        person.read(InstructionContent("a", "Words"), 0.0, may_go_on=True)


def test_a_sound_alone_asks_to_listen():
    page = instruction_page(InstructionContent("a", sound_s=2.0), ready=False)
    assert page.content is not None
    assert page.content.text == "Please listen."


def test_the_experimenter_reads_it_aloud_and_enter_goes_on():
    lines = iter([None, "", None, ""])
    person = TerminalRespondent(Console(quiet=True), waiting_line=lambda: next(lines))
    content = InstructionContent("a", "Words")
    waits = [person.read(content, 0.0, may_go_on=ready) for ready in (False, False, True, True)]
    assert [each is None for each in waits] == [False, False, False, True]


def test_a_session_does_not_wait_for_lines_that_cannot_come(tmp_path, monkeypatch):
    (tmp_path / "typed").write_text("\n")
    with (tmp_path / "typed").open() as typed:
        monkeypatch.setattr(sys, "stdin", typed)
        person = TerminalRespondent(Console(quiet=True))
        content = InstructionContent("a", "Words")
        assert person.read(content, 0.0, may_go_on=True) is None
        with pytest.raises(InputError, match="input ended"):
            person.read(content, 0.0, may_go_on=True)


def silent_speaker() -> SystemSpeaker:
    miniaudio = pytest.importorskip("miniaudio", reason="miniaudio is not installed")
    return SystemSpeaker(backends=[miniaudio.Backend.NULL])  # it consumes, and nobody hears


def test_a_sound_plays_without_anybody_waiting_for_it(tmp_path):
    write_wav(tmp_path / "a.wav", 60.0)
    sound = read_sound(tmp_path / "a.wav")
    with silent_speaker() as speaker:
        speaker.prepare(sound)
        began_s = time.perf_counter()
        speaker.play(sound)
        assert time.perf_counter() - began_s < 60.0  # it lasts longer
        speaker.play(sound)  # again, from its beginning
        speaker.stop()
        speaker.stop()


def test_a_prepared_sound_is_not_decoded_again_when_it_is_read_again(tmp_path, monkeypatch):
    write_wav(tmp_path / "a.wav", 0.2)
    with silent_speaker() as speaker:
        speaker.prepare(read_sound(tmp_path / "a.wav"))
        monkeypatch.setattr(speaker, "prepare", None)
        speaker.play(read_sound(tmp_path / "a.wav"))


def test_run_opens_the_device_and_decodes_all_sounds_before_the_session(tmp_path, monkeypatch):
    null = [pytest.importorskip("miniaudio", reason="miniaudio is not installed").Backend.NULL]
    make = SystemSpeaker.__init__
    monkeypatch.setattr(SystemSpeaker, "__init__", lambda self: make(self, backends=null))
    with open_speaker(told(tmp_path)) as speaker:
        assert speaker is not None
        monkeypatch.setattr(speaker, "prepare", None)
        speaker.play(read_sound(tmp_path / "welcome.wav"))
    (tmp_path / "welcome.wav").write_bytes((tmp_path / "welcome.wav").read_bytes()[:30])
    with pytest.raises(InputError, match=r"welcome\.wav"), open_speaker(told_again(tmp_path)):
        pass


def test_what_is_played_is_the_file_then_silence():
    from vrcomfort.headset.sound import _chunks

    stream = _chunks(bytes(range(20)))
    next(stream)
    played = stream.send(3) + stream.send(4)
    assert played == bytes(range(20)) + bytes(8)


def test_a_wav_that_only_its_header_is_good_of_is_told(tmp_path):
    with silent_speaker() as speaker, pytest.raises(InputError, match="x cannot be played"):
        speaker.prepare(Sound("x", 1.0, b"RIFF1234WAVEnothing of it is so"))


def test_no_sound_device_is_one_sentence_before_the_session(tmp_path, monkeypatch, capfd):
    def refuse(self, backends=None):
        raise InputError("there is no sound device; plug in headphones")

    monkeypatch.setattr(SystemSpeaker, "__init__", refuse)
    with open_speaker(told(tmp_path)) as speaker:
        assert speaker is None
    said = " ".join(capfd.readouterr().err.split())
    assert "there is no sound device" in said
    assert "texts stand in for the sounds of welcome" in said
    alone = told(tmp_path, WELCOME.replace('text = "Welcome to the study."', ""))
    with (
        pytest.raises(InputError, match="or give instruction `welcome` a text"),
        open_speaker(alone),
    ):
        pass
    with open_speaker(tiny_protocol(tmp_path)) as speaker:
        assert speaker is None  # and no device was looked for


def test_without_miniaudio_a_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "miniaudio", None)
    with pytest.raises(InputError, match=r"pip install miniaudio$"):
        SystemSpeaker()


def test_simulate_tells_instructions(tmp_path):
    told(tmp_path)
    simulate_sessions(
        load_protocol(tmp_path / "tiny.toml"), participants=1, out=tmp_path / "S", seed=None,
        size_px=(16, 16), exposure_s=None, frames=False,
    )  # fmt: skip
    assert len(events(tmp_path)) == 3
    assert "sound welcome.wav, 1.5 of 1.5 s" in events(tmp_path)[0][1]
