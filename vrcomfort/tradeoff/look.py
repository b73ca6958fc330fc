"""One method on one case, without tables: what somebody who changes a shader looks at."""

from __future__ import annotations

from typing import Any

from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.measure import errors_of
from vrcomfort.tradeoff.methods import Method
from vrcomfort.tradeoff.store import Store


def look(method: Method, case: Case, scope: Scope, store: Store) -> dict[str, Any]:
    """Return the errors of a method: those of :func:`measure.eye_errors`, and flicker.

    Nothing but references is taken from the store or kept in it.
    """
    return errors_of(case, scope, method, store)
