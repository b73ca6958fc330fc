"""Checks before every export: the study is whole, and the folder is new."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study


def require_whole(study: Path) -> None:
    """Raise `InputError` where a study is an import, or `vrcomfort verify` finds a fault."""
    if (study / "import.json").exists():
        message = "this is an import, and not a recorded study; hand its source on"
        raise InputError(message, file=study)
    if faults := verify_study(study).faults:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        message = f"this study is not whole: {faults[0]}{more}; see vrcomfort verify"
        raise InputError(message, file=study)


@contextmanager
def new_folder(study: Path, out: Path) -> Iterator[Path]:
    """Yield a path where a folder can be made; it becomes `out` when all went well.

    Raises
    ------
    InputError
        If `out` is there already, or lies in the study.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError("is there already; choose a new folder as --out", file=out)
    if study.resolve() in {out.resolve(), *out.resolve().parents}:
        raise InputError("lies in the study; choose a folder outside of it", file=out)
    draft = out.with_name(f".{out.name}.part")
    shutil.rmtree(draft, ignore_errors=True)
    try:
        yield draft
        if out.exists():
            out.rmdir()
        draft.rename(out)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
