"""A folder of finished work: arrays under the hash of all that they depend on."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from vrcomfort import __version__
from vrcomfort.errors import InputError
from vrcomfort.files import open_file, read_bytes
from vrcomfort.resources import data_folder
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene

PACKAGE = Path(__file__).resolve().parent.parent


class Store:
    """Keeps arrays and their facts; a file appears whole or not at all.

    Parameters
    ----------
    folder
        Made if it is missing.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            probe = folder / f".probe-{os.getpid()}"
            probe.touch()
            probe.unlink()
        except OSError as error:
            raise InputError(
                f"cannot be written to ({error.strerror}); choose another --cache", file=folder
            ) from error

    def read(self, key: str) -> dict[str, NDArray[Any]] | None:
        """Return the arrays under a key; None where there are none, or half a file."""
        try:
            with open_file(self._path(key)) as file, np.load(file, allow_pickle=False) as found:
                return dict(found)
        except (OSError, ValueError, EOFError, BadZipFile):
            return None

    def write(self, key: str, **arrays: NDArray[Any]) -> None:
        """Keep arrays under a key, in place of earlier ones."""
        path = self._path(key)
        # Renamed when it is whole: workers read and write the same folder at once.
        partial = path.with_suffix(f".{os.getpid()}.part")
        with partial.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)
        partial.replace(path)

    def has(self, key: str) -> bool:
        """Return whether something is kept under a key."""
        return self._path(key).exists()

    def keys(self, start: str) -> list[str]:
        """Return the keys that begin so and under which something is kept."""
        return sorted(path.stem for path in self.folder.glob(f"{start}*.npz"))

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"


def default_folder() -> Path:
    """Return where caches belong on this system."""
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "vrcomfort" / "tradeoff"


def key_of(kind: str, *facts: Any) -> str:
    """Return a file name for data that depends on `facts` (any JSON)."""
    text = json.dumps([__version__, *facts], sort_keys=True, default=str)
    return f"{kind}-{hashlib.sha256(text.encode()).hexdigest()[:24]}"


@cache
def scene_and_hash(name: str) -> tuple[Scene, str]:
    """Return a scene and the hash of all that it holds."""
    scene = load_scene(name)
    return scene, hashlib.sha256(pickle.dumps(scene)).hexdigest()


@cache
def method_code() -> str:
    """Return the hash of all shaders and of the Python that draws and judges methods."""
    shaders = sorted(path for path in data_folder("shaders").rglob("*") if path.is_file())
    folders = ("render", "optics", "tradeoff")
    python = [path for name in folders for path in sorted((PACKAGE / name).rglob("*.py"))]
    return _hash([*shaders, *python])


def _hash(files: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for path in files:
        digest.update(path.name.encode())
        digest.update(read_bytes(path))
    return digest.hexdigest()
