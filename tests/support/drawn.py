"""In which forms the reports of tests have figures, where a test does not say so itself.

None: figures take nine tenths of the time of a small report. ``pytest --draw`` makes them SVG.
"""

from __future__ import annotations

from typing import Literal

FORMS: list[Literal["svg", "png", "pdf"]] = []
