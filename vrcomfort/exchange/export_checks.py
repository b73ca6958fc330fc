"""Checks before every export: the study is whole, and the folder is new."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.exchange.verifying.findings import Finding
from vrcomfort.records.choice import EVERYTHING, Choice, SessionName, session_name
from vrcomfort.records.reader import Session


def require_whole(study: Path, choice: Choice = EVERYTHING) -> list[Finding]:
    """Return the faults that `vrcomfort verify` finds, where they are accepted.

    Raises
    ------
    InputError
        If a fault is not accepted, or what is to be left out is not there.
    """
    choice.require_there(study)
    faults = verify_study(study, without=choice.without).faults
    if faults and not choice.accept_flagged:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        message = f"this study is not whole: {faults[0]}{more}; see vrcomfort verify"
        hint = "--without P07/ses-2 leaves a session out, --accept-flagged takes all as it is"
        raise InputError(f"{message}; {hint}", file=study)
    return faults


def flagged_sessions(faults: Sequence[Finding]) -> set[SessionName]:
    """Return the sessions with faults in their folders."""
    places = (each.file.removeprefix("sub-").split("/") for each in faults)
    named = (place for place in places if len(place) > 1)
    return {session_name("/".join(place[:2])) for place in named if place[1].startswith("ses-")}


@contextmanager
def from_damaged(session: Session, faults: Sequence[Finding]) -> Iterator[None]:
    """Name the remedy where a damaged session with accepted faults cannot be copied."""
    try:
        yield
    except (ValueError, LookupError, TypeError, OSError) as error:
        if not faults:
            raise
        name = f"{session.participant}/ses-{session.number}"
        message = (
            f"this session is too damaged to be copied ({error}); leave it out: --without {name}"
        )
        raise InputError(message, file=session.folder) from error


@contextmanager
def new_folder(study: Path, out: Path) -> Iterator[Path]:
    """Yield a path where a folder can be made; it becomes `out` when all went well.

    Raises
    ------
    InputError
        If `out` is there already, or lies in the study.

    Notes
    -----
    Errors name files by where they would have been in `out`.
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
    except InputError as error:
        if error.file is None or not Path(error.file).is_relative_to(draft):
            raise
        raise error.in_file(out / Path(error.file).relative_to(draft)) from error
    except OSError as error:
        if error.filename is not None and Path(error.filename).is_relative_to(draft):
            error.filename = str(out / Path(error.filename).relative_to(draft))
        raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def said_of(choice: Choice, faults: Sequence[Finding]) -> str:
    """Return the section of a README on exclusions and accepted faults; blank without any."""
    sentences = choice.sentences([str(each) for each in faults])
    lines = "".join(f"- {each}\n" for each in sentences)
    return f"\n## Not the whole study as recorded\n\n{lines}" if lines else ""
