"""Drafts tables again, with the columns that no rule knows."""

from __future__ import annotations

from collections.abc import Sequence

from vrcomfort.importing.suggest.cells import varies_within
from vrcomfort.importing.suggest.conditions import FEW_IN
from vrcomfort.importing.suggest.draft import PEOPLE, OpenDoubt
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.importing.suggest.vocabulary import Known


def _facts_of_people(
    draft: TableDraft, known: Known, columns: Sequence[int], twice: Sequence[str]
) -> TableDraft:
    """Take columns for facts of people, but those in which a code of several rows has two; ask."""
    torn = [c for c in columns if varies_within(draft.table, c, draft.people)]
    found = TableDraft(draft.tables, known, of_person=[c for c in columns if c not in torn])
    if twice:
        names = ", ".join(repr(draft.table.headings[c]) for c in torn)
        assumed = f"it is; {names} differ there, and are left out" if torn else "it is"
        question = f"{', '.join(twice)} has several rows in {draft.files[0]}: is it one person?"
        found.doubts.append(OpenDoubt(question, assumed, PEOPLE))
    return found


def with_left_over(draft: TableDraft, known: Known, *, alone: bool) -> TableDraft:
    """Return a draft that also takes the columns that no rule knows.

    Parameters
    ----------
    alone
        The table is the only one, or none names people: it holds what was measured, not who the
        people of others are.
    """
    left, found = draft.left, draft
    if not draft.known:
        who = draft.people
        twice = [] if who is None else draft.with_several_rows(who)
        once = who is not None and len(twice) * FEW_IN <= len(draft.table.rows)
        words = draft.words_of_people() if once and not alone else []
        if not (left or words or twice) or (who is None and not alone):
            return draft
        found = TableDraft(draft.tables, known, answered=True)  # which may have conditions
        of_people = not draft.outcomes and (twice or not left or not found.has_conditions)
        if once and not alone and of_people:
            return _facts_of_people(draft, known, [*found.left, *words], twice)
        left = found.left
    own = draft.of_other_rows() if draft.known else []
    if not left and not own:
        return draft
    whole = TableDraft(draft.tables, known, left)
    if len(whole.table.rows) > len(draft.table.rows):  # which may tell other columns apart
        left = left | whole.left
        whole = TableDraft(draft.tables, known, left)
    if own := [*own, *whole.once_a_person()]:
        rest = {column: each for column, each in left.items() if column not in own}
        whole = TableDraft(draft.tables, known, rest, of_person=own)
    return whole
