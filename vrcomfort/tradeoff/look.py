"""One method on one case, without tables: what somebody who changes a shader looks at."""

from __future__ import annotations

from typing import Any

from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.measure import errors_of
from vrcomfort.tradeoff.methods import Method
from vrcomfort.tradeoff.store import Store
from vrcomfort.tradeoff.timing import time_alone
from vrcomfort.tradeoff.traffic import traffic_of_method


def look(method: Method, case: Case, scope: Scope, store: Store) -> dict[str, Any]:
    """Return all that is known of a method: errors, cost, and what it sends through memory.

    Errors are those of :func:`measure.eye_errors`, and flicker; cost and traffic are those of the
    whole image. Nothing but references is taken from the store or kept in it.
    """
    cost = time_alone(method, case, scope)
    return {
        **errors_of(case, scope, method, store),
        "cost": cost.cost,
        "cost_interval": cost.cost_interval,
        **traffic_of_method(method, case, scope),
    }
