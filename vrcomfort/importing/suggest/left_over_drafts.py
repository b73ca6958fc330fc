"""Drafts tables again, with the columns that no rule knows."""

from __future__ import annotations

from vrcomfort.importing.suggest.evidence import texts
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.importing.suggest.vocabulary import Known


def with_left_over(draft: TableDraft, known: Known, *, alone: bool) -> TableDraft:
    """Return a draft that also takes the columns that no rule knows.

    Parameters
    ----------
    alone
        The table is the only one: it holds what was measured, not who the people of others are.
    """
    left, found = draft.left, draft
    if not draft.known:
        if not left or (draft.people is None and not alone):
            return draft
        found = TableDraft(draft.tables, known, answered=True)  # which may have conditions
        left = found.left
        who = draft.people
        once = who is not None and len(texts(draft.table, who)) == len(draft.table.rows)
        if once and not alone and not found.has_conditions:
            return TableDraft(draft.tables, known, of_person=left)
    own = draft.of_other_rows() if draft.known else []
    if not left and not own:
        return draft
    whole = TableDraft(draft.tables, known, left)
    if own := [*own, *whole.once_a_person()]:
        rest = {column: each for column, each in left.items() if column not in own}
        whole = TableDraft(draft.tables, known, rest, of_person=own)
    return whole
