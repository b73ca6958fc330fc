"""A disk that forgets what was not synced, for machines where no image can be mounted.

It is as kind as a journaling file system, not kinder: a sync of any file or folder keeps all names
as they are then, and of the contents only those of files that were synced themselves. What is kept
lies in a folder beside the study; `remains` makes a study of it.
"""

from __future__ import annotations

import json
import os
import shutil
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

NAMES = "names.json"


def install(study: Path, disk: Path) -> None:
    """Keep in `disk` what of `study` this process syncs from now on."""
    contents, held = disk / "contents", disk / "held"
    for folder in (contents, held):
        folder.mkdir(parents=True, exist_ok=True)
    root = study.resolve()

    def keep(sync: Callable[[int], None]) -> Callable[[Any], None]:
        def synced(file: Any) -> None:
            number = file if isinstance(file, int) else file.fileno()
            sync(number)
            _keep(number, root, disk)

        return synced

    changed: Any = os
    changed.fsync = keep(os.fsync)
    changed.fdatasync = keep(os.fdatasync)


def _keep(number: int, root: Path, disk: Path) -> None:
    path = Path(f"/proc/self/fd/{number}").readlink()
    if not path.is_relative_to(root):
        return
    found = os.fstat(number)
    if stat.S_ISREG(found.st_mode):
        draft = disk / "draft"
        shutil.copyfile(f"/proc/self/fd/{number}", draft)
        draft.replace(disk / "contents" / str(found.st_ino))
        held = disk / "held" / str(found.st_ino)
        if not held.exists() and path.exists():
            held.hardlink_to(path)  # or its number could become another file's
    names = {
        file.relative_to(root).as_posix(): file.stat().st_ino if file.is_file() else None
        for file in sorted(root.rglob("*"))
    }
    draft = disk / "draft"
    draft.write_text(json.dumps(names))
    draft.replace(disk / NAMES)


def remains(disk: Path, study: Path) -> None:
    """Make the folder that a power cut would have left."""
    study.mkdir(parents=True)
    names = disk / NAMES
    for name, number in json.loads(names.read_text() if names.exists() else "{}").items():
        file = study / name
        if number is None:
            file.mkdir(parents=True, exist_ok=True)
            continue
        file.parent.mkdir(parents=True, exist_ok=True)
        content = disk / "contents" / str(number)
        file.write_bytes(content.read_bytes() if content.exists() else b"")
