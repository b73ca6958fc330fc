"""Limits of a scene's size, so that a small file cannot ask for all memory of the machine."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vrcomfort.errors import InputError

Kind = Literal[
    "nodes",
    "draws",
    "items",
    "numbers",
    "zeros",
    "joints",
    "pixels",
    "file_bytes",
    "json_bytes",
    "json_marks",
]


@dataclass(frozen=True)
class SceneBudget:
    """The most that one scene may have, all files of it together.

    The defaults hold more than a headset can draw in time. Of the small files that ask for much
    (tests/scene/test_budget.py), none took more than 1.1 GiB until it was refused.

    Parameters
    ----------
    nodes
        Places in the scene graph.
    draws
        Primitives to draw: those of a mesh count for every node that has it.
    items
        Parts of the JSON: nodes, primitives, accessors, materials, key-frame channels, …
    numbers
        In accessors (vertices, indices, key frames), every time that one is read, and in what is
        made from them (flat normals, triangles of strips).
    zeros
        Numbers of accessors without data, which the file does not pay for.
    joints
        Of all skins: each is moved in every frame.
    pixels
        Of all images, once decoded; 4 bytes each.
    image_pixels
        Of one image.
    file_bytes
        Of the file and everything that it refers to.
    json_bytes, json_marks
        Of the JSON: its length, and how many brackets, braces and commas it has.
    """

    nodes: int = 2**18
    draws: int = 2**20
    items: int = 2**20
    numbers: int = 2**27
    zeros: int = 2**22
    joints: int = 1024
    pixels: int = 2**28
    image_pixels: int = 2**26
    file_bytes: int = 2**30
    json_bytes: int = 2**27
    json_marks: int = 2**24


_WORDS = {
    "nodes": "nodes",
    "draws": "primitives to draw",
    "items": "parts",
    "numbers": "numbers of vertices, indices and key frames",
    "zeros": "numbers without data",
    "joints": "joints",
    "pixels": "pixels of images",
    "file_bytes": "bytes",
    "json_bytes": "bytes of JSON",
    "json_marks": "brackets, braces and commas of JSON",
}


class Account:
    """The spent part of a budget while a file is read."""

    def __init__(self, path: Path, budget: SceneBudget) -> None:
        self.budget = budget
        self._path = path
        self._spent: Counter[Kind] = Counter()

    def spend(self, kind: Kind, amount: int, what: str) -> None:
        """Spend, before anything is allocated.

        Parameters
        ----------
        what
            The part of the file that needs it, for the message.

        Raises
        ------
        InputError
            If more is spent than there is.
        """
        self._spent[kind] += amount
        spent, most = self._spent[kind], getattr(self.budget, kind)
        if spent > most:
            message = f"{what} brings the scene to {spent} {_WORDS[kind]}, and {most} is the most"
            raise InputError(f"{message}; simplify the scene", file=self._path)
