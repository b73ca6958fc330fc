"""Makes a picture of what a command prints in a terminal.

    scripts/in_runtime.sh python scripts/terminal_picture.py doctor.svg vrcomfort doctor --timing
    python scripts/terminal_picture.py --png docs/images/doctor.png doctor.svg

Where scripts/in_runtime.sh runs it, Monado serves meanwhile. The second needs a Chromium
(``scripts/browser.sh``), which need not be where the command runs.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from contextlib import nullcontext
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from rich.console import Console
from rich.text import Text

from vrcomfort.headset.monado import Monado

WIDTH = 120
"""Characters of a line."""


def draw(svg: Path, command: list[str]) -> int:
    """Run a command, and draw what it prints; return its exit code."""
    looks = {"COLUMNS": str(WIDTH), "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    environment = {**os.environ, **looks}
    beside = Monado() if os.environ.get("VRCOMFORT_RUNTIME") else nullcontext()
    with beside:
        environment |= beside.environment if isinstance(beside, Monado) else {}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    console = Console(record=True, width=WIDTH, file=StringIO())
    console.print(f"$ {' '.join(command)}", highlight=False)
    console.print(Text.from_ansi(done.stdout.rstrip()))
    svg.write_text(console.export_svg(title=" ".join(command[:2])), encoding="utf-8")
    return done.returncode


def photograph(svg: Path, png: Path) -> None:
    """Let a browser draw a picture on its own, as large as it is."""
    text = svg.read_text("utf-8")
    [(width, height)] = re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', text)
    browser = Path(__file__).with_name("browser.sh")
    chromium = subprocess.run([browser], capture_output=True, text=True, check=True).stdout.strip()
    with TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        page.write_text(f'<body style="margin:0"><div style="width:{width}px">{text}</div>')
        subprocess.run(
            [chromium, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}",
             f"--window-size={float(width):.0f},{float(height):.0f}",
             f"--screenshot={png.absolute()}",
             page.as_uri()],
            check=True, capture_output=True,
        )  # fmt: skip
    with Image.open(png) as picture:
        few = picture.convert("RGB").quantize(64)
    few.save(png, optimize=True)


if __name__ == "__main__":
    if sys.argv[1] == "--png":
        photograph(Path(sys.argv[3]), Path(sys.argv[2]))
    else:
        sys.exit(draw(Path(sys.argv[1]), sys.argv[2:]))
