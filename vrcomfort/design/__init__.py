"""Orders of conditions and allocation to groups: squares, allocation, and their audit."""

from vrcomfort.design.audit import (
    AdministeredOrder,
    Audit,
    FactorAudit,
    StudyAudit,
    audit,
    audit_study,
)
from vrcomfort.design.orders import all_orders, latin_square, williams
from vrcomfort.design.pool import Design, Enrolment, build_design

__all__ = [
    "AdministeredOrder",
    "Audit",
    "Design",
    "Enrolment",
    "FactorAudit",
    "StudyAudit",
    "all_orders",
    "audit",
    "audit_study",
    "build_design",
    "latin_square",
    "williams",
]
