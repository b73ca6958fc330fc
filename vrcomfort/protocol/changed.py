"""Conditions with settings changed by texts such as ``vignette.open_deg=60``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.protocol.condition_check import NEEDS, idle
from vrcomfort.protocol.conditions import Condition
from vrcomfort.settings import did_you_mean, read_toml
from vrcomfort.settings.reading import Problem, fields_at, parse_data

NO_TABLE = "none"
"""Value of a table that takes it away."""


def changed(condition: Condition, option: str, texts: Iterable[str]) -> Condition:
    """Return a condition with some settings changed, checked as those of a protocol are.

    Parameters
    ----------
    option
        Name of what the texts were given as, for messages.
    texts
        ``table.setting=value``: the value as in TOML, words without quotation marks too; ``none``
        takes a table away. A table that the condition lacks is made, with its defaults.

    Raises
    ------
    InputError
        If a text names no setting, or its value cannot be.
    """
    data = condition.model_dump(exclude_unset=True)
    for text in texts:
        path, equals, value = (part.strip() for part in text.partition("="))
        if not (path and equals and value):
            raise InputError(f"{option} {text!r} changes nothing; write vignette.open_deg=60")
        _put(data, option, path, value)

    def refuse(found: Iterable[Problem]) -> InputError:
        return InputError(f"{option}: {next(iter(found)).message}")

    return parse_data(Condition, data, refuse)


def idle_settings(condition: Condition, texts: Iterable[str]) -> list[str]:
    """Return the changes of :func:`changed` that have no effect, in words."""
    said = []
    for text in texts:
        path = text.partition("=")[0].strip()
        table, _, name = path.partition(".")
        needs = NEEDS.get(table, {}).get(name)
        settings = getattr(condition, table, None)
        if needs and settings is not None and (reason := idle(settings, needs)):
            said.append(f"{path} does nothing with {reason}")
    return said


def _put(data: dict[str, Any], option: str, path: str, text: str) -> None:
    """Write a value into tables that are made on the way."""
    *tables, name = path.split(".")
    _check(option, path)
    inner = data
    for table in tables:
        inner[table] = dict(inner.get(table) or {})
        inner = inner[table]
    is_table = bool(fields_at(Condition, (*tables, name)))
    if not is_table:
        inner[name] = _value(text)
    elif text == NO_TABLE:
        inner[name] = None
    else:
        example = f"{path}.{fields_at(Condition, (*tables, name))[0]}=…"
        raise InputError(
            f"{option} {path}={text}: {path} is a table; write {example}, or {path}={NO_TABLE} "
            "to take it away"
        )


def _check(option: str, path: str) -> None:
    """Make sure that a condition can have a setting of this name."""
    parts = path.split(".")
    for depth, part in enumerate(parts):
        known = fields_at(Condition, parts[:depth])
        if part not in known:
            where = f" in {'.'.join(parts[:depth])}" if depth else ""
            hint = did_you_mean(part, known)
            raise InputError(f"{option} {path}: there is no setting `{part}`{where}; {hint}")


def _value(text: str) -> Any:
    """Return a TOML value, or the text itself where it is none: a word without its marks."""
    try:
        return read_toml(f"value = {text}", None)["value"]
    except InputError:
        return text
