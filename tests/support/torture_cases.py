"""Cases for the workers of `torture`: one that goes well, and each way of going wrong."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

from torture.case import OTHER
from torture.worker import named


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    if number == 1:
        with named("falls"):
            raise KeyError("sickness")
    if number == 2:
        time.sleep(3600.0)
    if number == 3:
        os._exit(9)
    if number == 4:
        bytes(16 << 30)
    if number == 5:
        return {"name": "wrong", "fault": OTHER}
    print("this is no answer")
    return {"name": f"fine {seed} in {folder.name[:6]}"}
