"""Who meets what in which order and in which group: squares, allocation, and their audit."""

from vrcomfort.design.audit import Audit, FactorAudit, Met, StudyAudit, audit, audit_study
from vrcomfort.design.orders import all_orders, latin_square, williams
from vrcomfort.design.pool import Design, Enrolment, build_design

__all__ = [
    "Audit",
    "Design",
    "Enrolment",
    "FactorAudit",
    "Met",
    "StudyAudit",
    "all_orders",
    "audit",
    "audit_study",
    "build_design",
    "latin_square",
    "williams",
]
