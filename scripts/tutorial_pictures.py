"""Follows docs/tutorial.md in a new folder, and makes its pictures of what came of it.

Run ``python scripts/tutorial_pictures.py``; a Chromium (``scripts/browser.sh``) shows the report.
"""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, View, yaw_pitch_roll
from vrcomfort.gpu.gl import create_context
from vrcomfort.headset.playback import default_fovs
from vrcomfort.protocol import load_protocol
from vrcomfort.render.output import read_rgb8
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.respondent.panel_layout import question_cells
from vrcomfort.respondent.panel_picture import Page, Painter
from vrcomfort.scene.load import load_scene

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "tutorial.md"
IMAGES = ROOT / "docs" / "images"


@dataclass(frozen=True)
class Step:
    """A block of commands on the page, and the lines that it says are printed."""

    commands: str
    printed: tuple[str, ...]


def steps() -> list[Step]:
    """Return what the page says to type."""
    blocks = re.findall(r"```sh\n(.*?)```\n(?:```text\n(.*?)```)?", PAGE.read_text("utf-8"), re.S)
    return [Step(commands, tuple(text.split("\n"))) for commands, text in blocks]


def follow(folder: Path) -> list[str]:
    """Type what the page says, in a folder; return what each block has printed.

    Raises
    ------
    subprocess.CalledProcessError
        If a command fails.
    """
    program = folder / "vrcomfort"
    program.write_text(
        f"#!{sys.executable}\nimport sys\nsys.path.insert(0, {str(ROOT)!r})\n"
        "from vrcomfort.cli import main\nsys.exit(main())\n"
    )
    program.chmod(0o755)
    printed = []
    for step in steps():
        done = subprocess.run(
            ["bash", "-ec", f'PATH="{folder}:$PATH"\n{step.commands}'],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise subprocess.CalledProcessError(
                done.returncode, step.commands, done.stdout, done.stderr
            )
        printed.append(done.stdout + done.stderr)
    return printed


def picture_of_conditions(folder: Path) -> Image.Image:
    """Return the temple under both conditions, side by side."""
    protocol, scene, size_px = (
        load_protocol(folder / "lens_study.toml"),
        load_scene("temple"),
        (400, 400),
    )
    head = Pose(np.array([-1.0, 1.6, -4.3]), yaw_pitch_roll(np.radians(47), np.radians(-4), 0.0))
    half = np.array([protocol.headset.ipd_m / 2, 0.0, 0.0])
    left, right = default_fovs(size_px)
    views = (View(head @ Pose(-half), left), View(head @ Pose(half), right))
    renderer = StereoRenderer(create_context(), size_px)
    eyes = []
    for condition in protocol.conditions:
        renderer.begin(scene, condition)
        frame = Frame(0, 0, 11_111_111, head, views, Pose(), discontinuity=True)
        drawn = renderer.render(frame, 0.0)  # focus is there at once: nothing was before
        eyes.append(read_rgb8(drawn.eyes[0]))
    return Image.fromarray(np.hstack(eyes))


def picture_of_the_panel(folder: Path) -> Image.Image:
    """Return the first question in both languages, side by side."""
    pages = []
    for language in ("en", "de"):
        protocol = load_protocol(folder / "lens_study.toml").spoken(language)
        form, words = protocol.form(protocol.questionnaires[0]), protocol.words
        item, count = form.items[3], len(form.items)
        title = words.place.format(number=4, count=count, instruction=form.instruction)
        cells = question_cells(item.answers, first=False, words=words)
        pages.append(Painter().draw(Page(title, item.text, cells, done=3 / count), None))
    return Image.fromarray(np.hstack(pages)).convert("RGB").resize((1024, 384))


def picture_of_the_report(folder: Path) -> Image.Image:
    """Return the top of the report as a browser shows it."""
    found = subprocess.run(
        [ROOT / "scripts" / "browser.sh"], capture_output=True, text=True, check=True
    )
    picture = folder / "report.png"
    with TemporaryDirectory() as profile:
        subprocess.run(
            [found.stdout.strip(), "--headless", "--no-sandbox", "--disable-gpu",
             f"--user-data-dir={profile}", "--hide-scrollbars", "--window-size=1000,1250",
             "--virtual-time-budget=2000", f"--screenshot={picture}",
             (folder / "lens_report" / "index.html").as_uri()],
            capture_output=True, check=True, timeout=120,
        )  # fmt: skip
    return Image.open(picture).convert("RGB")


def main() -> None:
    """Follow the page and write its pictures."""
    with TemporaryDirectory() as temporary:
        folder = Path(temporary)
        follow(folder)
        picture_of_conditions(folder).save(IMAGES / "tutorial_conditions.png", optimize=True)
        picture_of_the_panel(folder).save(IMAGES / "tutorial_panel.png", optimize=True)
        picture_of_the_report(folder).save(IMAGES / "tutorial_report.png", optimize=True)
        ratings = Image.open(folder / "lens_report" / "figures" / "ratings.png").convert("RGB")
        ratings.resize((800, round(800 * ratings.height / ratings.width))).save(
            IMAGES / "tutorial_ratings.png", optimize=True
        )


if __name__ == "__main__":
    main()
