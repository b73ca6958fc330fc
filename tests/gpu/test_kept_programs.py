"""Programs that tests share look new to each of them, and those that leak are still found."""

import pytest

VERTEX = "#version 450\nvoid main() { gl_Position = vec4(0); }"
FRAGMENT = """#version 450
#include "colour"
uniform float x = 2.5;
layout(binding = 3) uniform B { vec4 y; };
out vec4 c;
void main() { c = colour() + x + y; }
"""
COMPUTE = """#version 450
layout(local_size_x = 1) in;
layout(binding = 2) buffer B { float y; };
uniform float x;
void main() { y = x; }
"""


@pytest.fixture
def make(ctx):
    ctx.includes["colour"] = "vec4 colour() { return vec4(1); }"
    yield lambda: ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
    del ctx.includes["colour"]


def test_a_program_is_lent_to_one_user_at_a_time_and_as_new(make):
    one, other = make(), make()
    assert one.glo != other.glo
    name, one["x"], one["B"], one.extra = one.glo, 7.0, 5, "file"
    one.release()
    one.release()  # changes nothing
    again = make()
    assert (again.glo, again["x"].value, again["B"].value, again.extra) == (name, 2.5, 3, None)
    assert make().glo not in {name, other.glo}


def test_a_compute_shader_is_as_new(ctx):
    one = ctx.compute_shader(COMPUTE)
    name, one["x"], one["B"] = one.glo, 7.0, 5
    del one
    again = ctx.compute_shader(COMPUTE)
    assert (again.glo, again["x"].value, again["B"].value) == (name, 0.0, 2)


def test_another_include_is_another_program(ctx, make):
    name = make().glo
    ctx.includes["colour"] = "vec4 colour() { return vec4(2); }"
    assert make().glo != name
    ctx.includes["colour"] = "vec4 colour() { return vec4(1); }"
    assert make().glo == name


def test_a_program_that_is_held_counts_as_left_behind(ctx, make, count_objects):
    make()
    before = count_objects()["Program"]
    held = make()
    assert count_objects()["Program"] == before + 1
    del held
    assert count_objects()["Program"] == before
