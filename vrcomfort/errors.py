"""Exceptions for users: faults of their input, and a runtime that went away."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path


def pip_install(*packages: str, again: bool = False) -> str:
    """Return the install command for a missing or damaged package that pyproject.toml names.

    It names that package alone: vrcomfort is on no index, so its own extras can only be installed
    from a checkout. It adds to the environment that runs this, be that active or not, and made by
    venv, pipx or uv.

    >>> pip_install("pylsl").endswith(" install pylsl")
    True
    """
    # A shell reads < and > as redirections.
    quoted = (f'"{each}"' if set(each) & set("<>") else each for each in packages)
    command, force = _installer()
    return " ".join((command, *([force] if again else []), *quoted))


def _installer() -> tuple[str, str]:
    """Return the command that installs packages here, and its option that installs them again."""
    import shutil  # noqa: PLC0415 - for a remedy alone: every command imports this module
    import sysconfig  # noqa: PLC0415
    from importlib.util import find_spec  # noqa: PLC0415

    if (Path(sys.prefix) / "pipx_metadata.json").is_file():
        return "pipx inject vrcomfort", "--force"
    python = f'"{sys.executable}"' if " " in sys.executable else sys.executable
    if find_spec("pip") is None:  # as uv makes environments
        return f"uv pip install --python {python}", "--reinstall"
    pip = shutil.which("pip")
    if pip is not None and Path(pip).parent == Path(sysconfig.get_path("scripts")):
        return "pip install", "--force-reinstall"
    return f"{python} -m pip install", "--force-reinstall"


class InputError(ValueError):
    """Input that cannot be used, said in one sentence with its place.

    Parameters
    ----------
    message
        What is wrong and what to do about it.
    file, line, column
        Where: a path, a 1-based line, and a column name (tables) or 1-based column (text).
    others
        What else is wrong with the same file; the message says how many there are.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        column: str | int | None = None,
        others: Sequence[InputError] = (),
    ) -> None:
        self.message = message
        self.others = tuple(others)
        self.file = file
        self.line = line
        self.column = column
        place = [str(file)] if file is not None else []
        if line is not None:
            place.append(f"line {line}")
        if column is not None:
            place.append(f"column {column}")
        problems = "problems" if len(others) > 1 else "problem"
        told = f"{message} ({len(others)} more {problems} in this file)" if others else message
        super().__init__(f"{', '.join(place)}: {told}" if place else told)

    def in_file(self, file: str | Path) -> InputError:
        """Return this error with another file for its place."""
        return InputError(
            self.message, file=file, line=self.line, column=self.column, others=self.others
        )

    @property
    def alone(self) -> InputError:
        """Return this error without the others."""
        return InputError(self.message, file=self.file, line=self.line, column=self.column)


def spare(sources: Iterable[Path | None], outputs: Iterable[Path]) -> None:
    """Make sure that writing `outputs` replaces none of the files that are read.

    Two paths are one file also where one is a link to the other.

    Raises
    ------
    InputError
        Names the file.
    """
    read = [source for source in sources if source is not None and source.exists()]
    for output in outputs:
        if output.exists() and any(output.samefile(source) for source in read):
            message = "is read here, and would be overwritten; choose another output folder"
            raise InputError(message, file=output)


class RuntimeLostError(InputError):
    """The headset's runtime went away in the middle of a session; the records stay."""


def headset_ended(when: str) -> RuntimeLostError:
    """Return the exception for a headset that gives no more frames; `when` completes a sentence."""
    return RuntimeLostError(
        f"the headset ended the session {when}; what was recorded until here is kept: "
        "run with --resume"
    )
