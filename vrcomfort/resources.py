"""Finds the data folders that travel with the package."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from vrcomfort.errors import InputError

Folder = Literal["shaders", "protocols", "scenes", "analysis", "instruments"]

_PACKAGE = Path(__file__).resolve().parent


def data_folder(name: Folder) -> Path:
    """Return the folder of shipped data called `name`.

    A wheel carries the folders in ``vrcomfort/_data``; a checkout (also an editable install)
    has them beside the package.

    Raises
    ------
    FileNotFoundError
        If neither place has the folder: the installation is broken.
    """
    for candidate in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):
        if candidate.is_dir():
            return candidate
    raise FileNotFoundError(f"data folder {name!r} is missing from {_PACKAGE}; reinstall vrcomfort")


def site_folder() -> Path:
    """Return the folder of the documentation's pages.

    Raises
    ------
    InputError
        In a checkout in which they have not been built.
    """
    for candidate in (_PACKAGE / "_data" / "site", _PACKAGE.parent / "out" / "site"):
        if (candidate / "index.html").is_file():
            return candidate
    raise InputError("the documentation has not been built in this checkout; run: make docs")
