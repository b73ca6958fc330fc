"""What rows belong together: a scene, an effect and a lens."""

from __future__ import annotations

from typing import Any, TypeAlias

Key: TypeAlias = tuple[str, str, str]
"""Scene, effect and lens."""


def key_of_row(row: dict[str, Any]) -> Key:
    """Return what a row belongs to."""
    return row["scene"], row["effect"], row["lens"]


def named(key: Key) -> dict[str, Any]:
    """Return the columns that say it."""
    return dict(zip(("scene", "effect", "lens"), key, strict=True))


def figure_name(key: Key) -> str:
    """Return what the files of a figure are called; motion blur alone has no lens."""
    scene, effect, lens = key
    return f"{scene}_{effect}" if effect == "motion_blur" else f"{scene}_{effect}_lens{lens}"


def title(key: Key) -> str:
    """Return a heading."""
    scene, effect, lens = key
    words = f"{scene}, {effect.replace('_', ' ')}"
    if effect == "motion_blur":
        return words
    return f"{words}, {'lens of an eye' if lens == 'eye' else f'lens {lens} %'}"
