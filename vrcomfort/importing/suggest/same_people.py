"""Finds participants whose codes are spelt in two ways, in one table or from table to table."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from itertools import combinations
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.importing.rows import AnsweredAgainError, Imported, alike
from vrcomfort.importing.suggest.draft import (
    CURIOUS,
    ORDER,
    PEOPLE,
    SAME_PERSON,
    OpenDoubt,
    Stake,
    listed,
)
from vrcomfort.importing.suggest.shared_codes import OF_EXPOSURES
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.settings import toml_value

_SHOWN = 8
"""Pairs of codes that the question lists."""


def say_same_people(drafts: Sequence[TableDraft], imported: Imported) -> bool:
    """Make codes that are nearly the same one participant, and ask; return whether any are.

    They are where no code has answers to what another has answered, too, and no covariate
    contradicts: they are rows of one person, from other conditions, moments or files.
    """
    answered = _answered(imported)
    groups = alike(answered) or _called_otherwise(answered)
    if not groups:
        return False
    apart = [group for group in groups if not _are_one(group, answered, imported)]
    groups = apart or groups
    ways = Counter(re.sub(r"\d+", "0", code) for code in answered)
    usual = {
        code: max(group, key=lambda c: (ways[re.sub(r"\d+", "0", c)], len(answered[c])))
        for group in groups
        for code in group
    }
    one = {code: name for code, name in usual.items() if code != name}
    assumed = "they are not; `values` of participant make them one: "
    if not apart:
        assumed = "they are, as each code has answers that the other lacks: "
        for draft in drafts:
            _rename(draft, one)
    shown = listed([" and ".join(map(repr, group)) for group in groups], _SHOWN, "; ")
    question = f"Are these participants one person each: {shown}?"
    doubt = OpenDoubt(question, f"{assumed}values = {toml_value(one)}", SAME_PERSON)
    drafts[0].doubts.append(doubt)
    return not apart


def say_others(drafts: Sequence[TableDraft]) -> None:
    """Tell people of tables apart who share codes, but not their age, sex or the like; and ask.

    So it tells those who are counted row by row, unless they are as many.
    """
    counted = [draft for draft in drafts if draft.draft.values.get("participant") == COUNTED]
    if len({len(table.rows) for draft in counted for table in draft.tables}) > 1:
        question = "Are rows of {} of other people each, as their numbers differ?"
        stake = PEOPLE._replace(instead="in each table: participant = { count = true }")
        _tell_apart(counted, question, "they are", stake)
    known = {id(draft): _known(draft) for draft in drafts}
    others: dict[int, TableDraft] = {}
    for one, two in combinations(drafts, 2):
        a, b = known[id(one)], known[id(two)]
        shared = a.keys() & b.keys()
        torn = [w for w in shared if any(a[w][n] != b[w][n] for n in a[w].keys() & b[w].keys())]
        if shared and len(torn) * 2 > len(shared):
            others |= {id(one): one, id(two): two}
    question = "People have the same codes in {}: are they the same people?"
    _tell_apart([*others.values()], question, "they are not, as age or the like differs")


def _tell_apart(
    drafts: Sequence[TableDraft], question: str, assumed: str, stake: Stake = PEOPLE
) -> None:
    files = ", ".join(name for draft in drafts for name in draft.files)
    for draft in drafts:
        said = draft.draft.values["participant"]
        draft.draft.put("participant", {**(said if isinstance(said, dict) else {}), "apart": True})
    for draft in drafts[:1]:
        draft.doubts.append(OpenDoubt(question.format(files), assumed, stake))


COUNTED = {"count": True}
"""Participants that are the rows of a table."""


def without_unnamed_people(drafts: Sequence[TableDraft]) -> list[TableDraft]:
    """Return drafts without facts of people without codes, if other drafts have answers."""
    answered = [draft for draft in drafts if draft.known]
    named = [d for d in drafts if d.known or d.draft.values.get("participant") != COUNTED]
    return named if answered else [*drafts]


def say_contradictions(drafts: Sequence[TableDraft]) -> bool:
    """Leave out facts of people that an earlier table contradicts, and ask; return whether any."""
    told: dict[tuple[str, str], str] = {}
    found = False
    for draft in drafts:
        said = [(who, *fact) for who, facts in _known(draft, ()).items() for fact in facts.items()]
        torn = [name for who, name, text in said if told.get((who, name), text) != text]
        told = {(who, name): text for who, name, text in said} | told
        for name in dict.fromkeys(torn):
            found = True
            what = f"{_leave_out_fact(draft.draft.values, name)!r} of {draft.files[0]}"
            question = f"Another file contradicts {what}: which is right?"
            assumed = "the other: here it is no fact of people"
            draft.doubts.append(OpenDoubt(question, assumed, CURIOUS))
    return found


def count_exposures(drafts: Sequence[TableDraft], refusal: InputError) -> bool:
    """Count exposures in the order of the rows, where that is why files are refused; and ask."""
    if not isinstance(refusal, AnsweredAgainError):
        return False
    open_ = [d for d in drafts if d.known and not {"trial", "left_at"} & d.draft.values.keys()]
    for draft in open_:
        draft.draft.put("trial", {"count": True}, "exposures in the order of the rows")
        question = "Do people have several rows of one condition, in the order of time?"
        draft.doubts.append(OpenDoubt(question, "they do; exposures are numbered so", ORDER))
    return bool(open_)


def _leave_out_fact(values: dict[str, Any], name: str) -> str:
    """Let a mapping's table tell one fact less of its people; return the heading."""
    heading: str = values["participants"].pop(name)
    if not values["participants"]:
        del values["participants"]
    facts = [said for said in values.values() if isinstance(said, dict)]
    if all(heading != fact.get("column") for fact in facts):  # it may be the condition
        values["ignore"] = [*values.get("ignore", ()), heading]
    return heading


def _known(draft: TableDraft, but: Collection[str] = OF_EXPOSURES) -> dict[str, dict[str, str]]:
    """Return code → covariate → its text, where a table's codes are those of its own column."""
    fact, names = draft.draft.values.get("participant"), draft.draft.values.get("participants")
    column = fact.get("column") if isinstance(fact, dict) and "apart" not in fact else None
    if column is None or not isinstance(names, dict):
        return {}
    place = draft.table.headings.index(column)
    columns = {n: draft.table.headings.index(h) for n, h in names.items() if n not in but}
    rows = [row for table in draft.tables for row in table.rows if row[place]]
    return {row[place]: {n: row[c] for n, c in columns.items() if row[c]} for row in rows}


def _answered(imported: Imported) -> dict[str, set[tuple[object, ...]]]:
    """Return participant → what was answered, and when."""
    found: dict[str, set[tuple[object, ...]]] = {name: set() for name in imported.participants}
    for instrument, m in imported.responses:
        found.setdefault(m.participant, set()).add((instrument, m._replace(participant="")))
    for rating in imported.ratings:
        m = rating.administration
        key = (rating.instrument, m._replace(participant=""), rating.onset_s)
        found.setdefault(m.participant, set()).add(key)
    return found


def _are_one(
    group: Sequence[str], answered: Mapping[str, set[tuple[object, ...]]], imported: Imported
) -> bool:
    whole = set().union(*(answered[code] for code in group))
    known = [imported.participants.get(code, {}) for code in group]
    names = {name for each in known for name in each}
    agree = all(len({e[n] for e in known if e.get(n)}) <= 1 for n in names)
    return agree and len(whole) == sum(len(answered[code]) for code in group)


def _called_otherwise(answered: Mapping[str, Collection[object]]) -> list[list[str]]:
    """Return the pairs of ``7`` and ``P07``, where most people are called in both ways.

    Of ``ID7`` and ``P7``, all of one kind have no answers: a list of people alone has them.
    """
    ways: dict[str, dict[str, str]] = defaultdict(dict)
    for code in answered:
        if (match := _CODE.fullmatch(code)) is None:
            return []
        ways[match[1].casefold()][match[2]] = code
    if len(ways) != 2 or sum(map(len, ways.values())) < len(answered):
        return []
    one, two = (ways[name] for name in sorted(ways, reverse=True))
    pairs = [[code, two[number]] for number, code in one.items() if number in two]
    listed = any(not any(answered[code] for code in way.values()) for way in (one, two))
    most = len(pairs) * 4 >= max(len(one), len(two)) * 3
    return pairs if ("" in ways or listed) and most and len(pairs) >= _FEWEST_PAIRS else []


_CODE = re.compile(r"([^\W\d_]{0,12}[ _-]?)0*(\d+)")
_FEWEST_PAIRS = 3


def _rename(draft: TableDraft, one: Mapping[str, str]) -> None:
    """Give the names of participants under `values`, where a table has one of the codes."""
    said = draft.draft.values.get("participant")
    fact = dict(said) if isinstance(said, dict) else {}
    if fact.get("count"):
        return
    values: dict[str, str] = {}
    if isinstance(there := fact.get("values"), dict):
        values = {text: one.get(name, name) for text, name in there.items()}
    elif "column" in fact:
        column = draft.table.headings.index(fact["column"])
        cells = dict.fromkeys(cell for table in draft.tables for cell in table.column(column))
        values = {text: one[text] for text in cells if text in one}
    else:
        names = [f"{table.file} {table.sheet}" for table in draft.tables]
        values = {code: name for code, name in one.items() if any(code in n for n in names)}
    if values:
        draft.draft.put("participant", {**fact, "values": values})
