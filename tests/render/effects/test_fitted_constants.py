"""No number of a shader is bare: it has a name and a reason, or the benchmark that fits it."""

import re

from bench import fitted
from vrcomfort.gpu import shaders
from vrcomfort.resources import data_folder

FORMULAS = {
    "include/sky.glsl": "clouds and glow, chosen by eye",
    "include/surface.glsl": "the approximation that its source prints",
    "include/tone.glsl": "the curves of Khronos and of sRGB",
}
"""Files whose numbers belong to one formula."""

PLAIN = re.compile(r"\d\.0|0\.5|0\.25|0\.75|1\.5|2\.5|9\.0|1[256]\.0|255\.0|32768\.0|4294967296\.0")
NUMBER = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])")
NAMED = re.compile(r"\s*const (?:float|vec\d) \w+ = .+")


def texts():
    folder = data_folder("shaders")
    for file in sorted(folder.rglob("*.*")):
        yield file.relative_to(folder).as_posix(), file.read_text(encoding="utf-8")


def bare(text: str) -> list[str]:
    """Return the lines with a number that is neither plain nor named."""
    code = ((line, line.split("//")[0]) for line in text.splitlines())
    return [
        line.strip()
        for line, said in code
        if not NAMED.match(said) and not said.startswith("#")
        if any(not PLAIN.fullmatch(number) for number in NUMBER.findall(said))
    ]


def test_a_bare_number_is_found():
    assert bare("float a = 0.35 * b;\nfloat c = 0.5 * b + 16.0;\nconst float D = 0.35;") == [
        "float a = 0.35 * b;"
    ]


def test_no_number_of_a_shader_is_bare():
    found = {name: lines for name, text in texts() if (lines := bare(text))}
    assert {name: found[name] for name in found if name not in FORMULAS} == {}
    assert set(FORMULAS) <= set(found)


def test_all_notes_of_fits_name_the_benchmark():
    notes = {name: text.count("Fitted:") for name, text in texts() if "Fitted:" in text}
    constants = fitted.constants()
    assert {each.file: notes[each.file] for each in constants} == notes
    assert sum(notes.values()) == len(constants) >= 12


def test_the_benchmark_changes_one_constant_alone():
    for constant in fitted.constants():
        plain = shaders.source(constant.file).split("\n")
        with fitted.changed(constant, 2.0):
            other = shaders.source(constant.file).split("\n")
        changed = [pair for pair in zip(plain, other, strict=True) if len({*pair}) > 1]
        ((before, after),) = changed
        assert f"{constant.name} = " in before
        assert f"{constant.name} = {2 * constant.value:.9f};" in after
