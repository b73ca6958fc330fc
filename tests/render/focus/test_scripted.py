"""Focus by a script: the distances of a time, in the renderer, in files, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.support.render import at, glowing, scene, wall
from tests.support.study import PROTOCOL, read_rows, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, View
from vrcomfort.headset.playback import default_fovs
from vrcomfort.optics.focus import scripted_focus_m
from vrcomfort.protocol import Condition, DepthOfField, Focus
from vrcomfort.protocol.conditions import MotionBlur
from vrcomfort.render.graph import plan_focus
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder

SCRIPT = ((1.0, 4.0), (2.0, 4.0), (3.0, 1.0))


@pytest.mark.parametrize(
    ("time_s", "focus_m"),
    [(0.0, 4.0), (1.5, 4.0), (2.5, 1 / 0.625), (2.25, 1 / 0.4375), (3.0, 1.0), (9.0, 1.0)],
)
def test_focus_moves_linearly_in_dioptres(time_s, focus_m):
    assert scripted_focus_m(SCRIPT, time_s) == pytest.approx(focus_m)


def test_a_script_begins_again():
    for time_s in (0.0, 2.25, 3.9):
        again = scripted_focus_m(SCRIPT, time_s + 8.0, 4.0)
        assert again == pytest.approx(scripted_focus_m(SCRIPT, time_s))
    assert scripted_focus_m(SCRIPT, 8.0) == 1.0


CONDITION = Condition(
    name="script",
    focus=Focus(method="scripted", script=SCRIPT),
    depth_of_field=DepthOfField(law="eye"),
)


def test_the_renderer_goes_by_the_time_of_the_scene(ctx):
    size_px = (32, 32)
    content = scene([at(0, 0, -4, mesh=(0,))], [wall(20.0)], [glowing((1.0, 1.0, 1.0))])
    renderer = StereoRenderer(ctx, size_px)
    renderer.build(content, CONDITION)
    left, right = default_fovs(size_px)
    views = (View(Pose(), left), View(Pose(), right))
    for index, time_s in enumerate((0.5, 2.5, 3.5)):
        frame = Frame(index, index, 1, Pose(), views, Pose(), discontinuity=index == 0)
        (sample,) = renderer.render(frame, time_s).focus_samples
        expected = scripted_focus_m(SCRIPT, time_s)
        assert (sample.frame_index, sample.focus_m) == (index, pytest.approx(expected))
        assert sample.focus_raw_m == sample.focus_m
        assert np.isnan(sample.rays_m).all()
        texture = renderer.focus.texture
        written = np.frombuffer(texture.read(), np.float32)
        assert written[0] == pytest.approx(expected, rel=1e-6)
    renderer.release()


def test_the_plan_says_that_nothing_is_drawn():
    planned = plan_focus(scene([], [], []), CONDITION)
    assert not planned.needed
    assert "a script of 3 distances" in planned.reason


OWN = 'method = "scripted", script = [[0.0, 2.0]], scripts = { '


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ('method = "scripted"', 'method = "scripted" needs a `script`'),
        ('method = "scripted", script = [[1.0, 2.0], [1.0, 3.0]]', "times of `script` must rise"),
        ('method = "scripted", script = [[9.0, 2.0]], script_every_s = 5.0', "make it longer"),
        ('method = "scripted", script = [[0.0, 0.0]]', "equal to 0.001"),
        ('method = "scripted", script = [[0.0, 2.0]], law = "instant"', "`law` does nothing with"),
        ("script = [[0.0, 2.0]]", '`script` does nothing with method = "nine_ray"'),
        (f"{OWN}tempel = [[0.0, 3.0]] }}", "this study has no scene `tempel`"),
        (f"{OWN}temple = [[1.0, 3.0], [1.0, 2.0]] }}", "times of `scripts.temple` must rise"),
        (f"{OWN}temple = [] }}", "`scripts.temple` has no distances"),
    ],
)
def test_scripts_that_cannot_be_are_refused(tmp_path, settings, says):
    blur = 'name = "blur"\n'
    text = PROTOCOL.replace(blur, f"{blur}focus = {{ {settings} }}\n", 1)
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text)
    assert says in str(caught.value)
    assert caught.value.line == 12


@pytest.mark.slow
def test_simulated_sessions_record_the_script(run, tmp_path):
    smoke = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    scripted = 'method = "scripted"\nscript = [[0.0, 9.0]]\n'
    scripted += "scripts.temple = [[0.0, 4.0], [0.1, 1.0]]\n"
    text = smoke.replace('law = "linear_dioptre"\nmean = "dioptres"\n', scripted, 1)
    assert text != smoke
    file = tmp_path / "scripted.toml"
    file.write_text(text, encoding="utf-8")
    code, _, err = run("simulate", file, "-n", 1, "--out", tmp_path / "S", "--size", "32x32")
    assert code == 0, err
    session = tmp_path / "S" / "sub-P01" / "ses-1"
    trials = {row["trial"]: row["condition"] for row in read_rows(session / "trials.csv")}
    frames = [row for row in read_rows(session / "frames.csv") if trials[row["trial"]] == "dof"]
    start_ns = int(frames[0]["xr_time_ns"])
    assert len(frames) > 4
    for row in frames:
        time_s = (int(row["xr_time_ns"]) - start_ns) / 1e9
        expected = scripted_focus_m(((0.0, 4.0), (0.1, 1.0)), time_s)
        assert float(row["focus_m"]) == pytest.approx(expected, rel=1e-4)
    manifest = json.loads((session / "manifest.json").read_text(encoding="utf-8"))
    assert "scripted" in json.dumps(manifest["settings"])


def test_a_scene_has_the_script_of_its_own():
    focus = Focus(method="scripted", script=SCRIPT, scripts={"court": ((0.0, 7.0),)})
    condition = Condition(name="script", focus=focus)
    assert condition.in_scene("court").focus == Focus(method="scripted", script=((0.0, 7.0),))
    assert condition.in_scene("hall") is condition


def test_motion_blur_needs_no_focus():
    assert not plan_focus(scene([], [], []), Condition(name="m", motion_blur=MotionBlur())).needed
