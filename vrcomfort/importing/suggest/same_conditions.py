"""Finds conditions that tables spell in two ways."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest.draft import SAME_CONDITION, OpenDoubt, listed
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.settings import toml_value

_SHOWN = 8
"""Pairs of names that the question lists."""


def say_same_conditions(drafts: Sequence[TableDraft], imported: Imported) -> bool:
    """Make conditions that differ in case or blanks alone one, and ask; return whether any are.

    No person has answered the same under both.
    """
    spelt: dict[str, list[str]] = defaultdict(list)
    for name in imported.conditions:
        spelt["".join(name.casefold().split())].append(name)
    one = {name: names[0] for names in spelt.values() for name in names[1:]}
    renamed = {
        (instrument, m._replace(condition=one.get(m.condition, m.condition)))
        for instrument, m in imported.responses
    }
    crossed = any(draft.levels for draft in drafts)
    if not one or crossed or len(renamed) < len(imported.responses):
        return False
    changed = [draft for draft in drafts if _rename(draft, one)]
    shown = listed([f"{name!r} and {again!r}" for again, name in one.items()], _SHOWN, "; ")
    question = f"Are these conditions, spelt in two ways, the same: {shown}?"
    for draft in changed[:1]:
        assumed = f"they are: values = {toml_value(one)}"
        draft.doubts.append(OpenDoubt(question, assumed, SAME_CONDITION))
    return bool(changed)


def _rename(draft: TableDraft, one: Mapping[str, str]) -> bool:
    """Give conditions of a table other names; return whether it says any of them."""
    found = False
    sources = [*draft.draft.lists.get("questionnaires", ()), *draft.draft.lists.get("scores", ())]
    for each in sources:
        said = each.values.get("condition")
        if isinstance(said, str) and said in one:
            each.put("condition", one[said])
            found = True
    fact = draft.draft.values.get("condition")
    if not isinstance(fact, dict):
        return found
    name = fact.get("constant")
    if isinstance(name, str) and name in one:
        draft.draft.put("condition", {**fact, "constant": one[name]})
        return True
    values = fact.get("values", {})
    if isinstance(column := fact.get("column"), str) and not values:
        place = draft.table.headings.index(column)
        values = {text: text for table in draft.tables for text in table.texts[place]}
    if {*values.values()} & one.keys():
        renamed = {text: one.get(name, name) for text, name in values.items()}
        draft.draft.put("condition", {**fact, "values": renamed})
        return True
    return found
