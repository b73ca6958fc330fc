"""The wheel carries what it needs, and importing it needs no GPU."""

from __future__ import annotations

import re
import subprocess
import sys
import sysconfig
import venv
import zipfile
from collections import Counter
from pathlib import Path

import pytest

from tests.support.places import ROOT

COMPILE_EVERY_SHADER = """
from typing import get_args

import vrcomfort
from vrcomfort.headset.eye_painter import EyePainter
from vrcomfort.protocol import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.protocol.conditions import (
    BackgroundBlur, FocusRuleName, Kernel, MoveRamp, RefocusLawName, RelocationBlur, SpeedBlur,
    Vignette,
)
import numpy as np
from vrcomfort.geometry import HiddenArea
from vrcomfort.gpu import shaders
from vrcomfort.gpu.gl import create_context
from vrcomfort.scene.load import load_scene
from vrcomfort.render.display import ImageHasher
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff.brute_force import Reference
from vrcomfort.resources import data_folder

assert "_data" in str(data_folder("shaders")), data_folder("shaders")
assert "site-packages" in vrcomfort.__file__, vrcomfort.__file__

read = set()
source = shaders.source
shaders.source = lambda name: (read.add(name), source(name))[1]

context, scene = create_context(), load_scene("depths")
for law in ("linear", "dioptre"):
    condition = Condition(
        name="all", depth_of_field=DepthOfField(law=law), motion_blur=MotionBlur()
    )
    StereoRenderer(context, (16, 16), headset_depth="blur_aware").begin(scene, condition)
    Reference(context, scene, condition, (16, 16))._pass
streaks = Condition(name="s", motion_blur=MotionBlur())
StereoRenderer(context, (800, 16)).begin(scene, streaks)  # too wide for one step
fast = SpeedBlur(moving=MoveRamp(from_m_s=1, to_m_s=2))
for method in ("reconstruction", "per_pixel"):
    condition = Condition(name="m", motion_blur=MotionBlur(method=method), speed_blur=fast)
    StereoRenderer(context, (16, 16)).begin(scene, condition)
both = {"depth_of_field": DepthOfField(), "motion_blur": MotionBlur()}
later = Condition(name="l", effect_order=("motion_blur", "depth_of_field"), **both)
StereoRenderer(context, (16, 16)).begin(scene, later)
narrow = Condition(name="n", vignette=Vignette(colour="scene"), relocation_blur=RelocationBlur())
StereoRenderer(context, (16, 16)).begin(scene, narrow)
layers = Condition(name="l", background_blur=BackgroundBlur(foreground=("*",)))
StereoRenderer(context, (16, 16)).begin(scene, layers)
for kernel in get_args(Kernel):
    wide = DepthOfField(kernel=kernel, max_radius_percent=10)
    StereoRenderer(context, (128, 16)).begin(scene, Condition(name="k", depth_of_field=wide))
for samples in (12, 16, 36):
    few = DepthOfField(samples=samples, max_radius_percent=10)
    StereoRenderer(context, (64, 16)).begin(scene, Condition(name="samples", depth_of_field=few))
script = [(0.0, 2.0), (1.0, 0.5)]
rules = [
    Focus(method=method, without_gaze="nine_ray", script=script)
    for method in get_args(FocusRuleName)
]
for rule in (*rules, Focus(method="autofocus_zone", zone_statistic="minimum")):
    condition = Condition(name="rule", focus=rule, depth_of_field=DepthOfField())
    StereoRenderer(context, (16, 16)).begin(scene, condition)
for law in get_args(RefocusLawName):
    condition = Condition(name="law", focus=Focus(law=law), depth_of_field=DepthOfField())
    StereoRenderer(context, (16, 16)).begin(scene, condition)
EyePainter(context)  # reads its own pair
ImageHasher(context)
views = DepthOfField(law="dioptre", views=16, max_radius_percent=10)
StereoRenderer(context, (64, 16)).begin(scene, Condition(name="views", depth_of_field=views))
edge = np.array([[-2, -2], [-0.9, -2], [-2, 2]], np.float32)
hidden = HiddenArea(edge, np.array([[0, 1, 2]], np.uint32))
StereoRenderer(context, (64, 64), hidden=(hidden,) * 2).begin(scene, later)
print(*read, "display/picture.vert", "display/picture.frag")
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out)]
    subprocess.run([*command, str(ROOT)], check=True, capture_output=True)
    return next(out.glob("*.whl"))


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["shaders", "protocols", "scenes", "analysis", "instruments"])
def test_wheel_carries_every_committed_file_of_the_data_folders(wheel: Path, folder: str) -> None:
    tracked = subprocess.run(
        ["git", "ls-files", folder], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split()
    carried = set(zipfile.ZipFile(wheel).namelist())
    assert tracked
    assert {f"vrcomfort/_data/{name}" for name in tracked} <= carried


@pytest.mark.slow
def test_wheel_carries_the_documentation(wheel: Path) -> None:
    carried = set(zipfile.ZipFile(wheel).namelist())
    pages = {f"vrcomfort/_data/site/{each.stem}.html" for each in (ROOT / "docs").glob("*.md")}
    assert pages <= carried
    assert "vrcomfort/_data/site/search/search_index.js" in carried


@pytest.mark.slow
def test_every_shader_compiles_from_an_installed_wheel(wheel: Path, tmp_path: Path) -> None:
    environment = tmp_path / "venv"
    venv.create(environment, with_pip=False)
    site = next((environment / "lib").glob("python*")) / "site-packages"
    # Dependencies come from the running environment; vrcomfort itself from the wheel alone.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    zipfile.ZipFile(wheel).extractall(site)
    result = subprocess.run(
        [environment / "bin" / "python", "-I", "-c", COMPILE_EVERY_SHADER],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert result.returncode == 0, result.stderr
    folder = ROOT / "shaders"
    files = (path for path in folder.rglob("*") if path.is_file())
    shaders = {path.relative_to(folder).as_posix() for path in files}
    assert set(result.stdout.split()) == shaders, "every shader is compiled, and none is unused"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "forbidden"),
    [
        ("vrcomfort", ("moderngl", "xr", "pingouin", "matplotlib", "pandas")),
        ("vrcomfort.cli", ("moderngl", "xr", "pingouin", "matplotlib")),
        ("vrcomfort.report", ("moderngl", "xr")),
        ("vrcomfort.session.run", ("duckdb", "pandas")),
        ("vrcomfort.console.server", ("numpy", "pydantic")),
    ],
)
def test_importing_loads_only_what_is_needed(module: str, forbidden: tuple[str, ...]) -> None:
    code = f"import sys, {module}; print(*(set({forbidden!r}) & set(sys.modules)))"
    result = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert result.stdout.strip() == ""


def test_no_two_public_classes_have_one_name() -> None:
    texts = (file.read_text("utf-8") for file in (ROOT / "vrcomfort").rglob("*.py"))
    names = Counter(name for text in texts for name in re.findall(r"(?m)^class ([A-Z]\w*)", text))
    assert len(names) > 500
    assert [name for name, count in names.items() if count > 1] == []
