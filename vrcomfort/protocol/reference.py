"""The page of all keys of a protocol, made from its models: ``docs/protocol_reference.md``."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from vrcomfort.protocol.condition_check import NEEDS, condition_tables
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order_check import OF_RULES
from vrcomfort.settings.schema import reference

HEAD = """\
# Every key of a protocol

Made from the models that read protocols (`python scripts/protocol_reference.py`), and so complete.
An editor can complete and check these keys: [protocols.md](protocols.md#in-an-editor). A table in
double brackets stands once for each entry.

"""


def protocol_reference() -> str:
    """Return the page."""
    notes = {
        table.__name__: {
            key: _only_with(needs) for key, needs in NEEDS[name].items() if not _alone(needs)
        }
        for name, table in condition_tables()
    }
    rules = {key: _only_with({"rule": rules}) for key, rules in OF_RULES.items()}
    return HEAD + reference(Protocol, {**notes, "Order": rules})


def _alone(needs: Any) -> bool:
    """Return whether a setting needs nothing but a number in a range, which its text says."""
    return any(isinstance(values, range) for values in needs.values())


def _only_with(needs: Any) -> str:
    said = [f"`{choice}` = {_words(values)}" for choice, values in needs.items()]
    return f"Only with {' and '.join(said)}."


def _words(values: Collection[Any]) -> str:
    return " or ".join(f'`"{value}"`' for value in values)
