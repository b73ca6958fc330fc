"""Questionnaires: what is asked, how it is read from files, how it is scored."""

from vrcomfort.questionnaire.instruments import FMS, INSTRUMENTS, MISC, SSQ, Instrument, Item
from vrcomfort.questionnaire.scoring import score_complete_ssq, score_ssq
from vrcomfort.questionnaire.ssq import LOADINGS, WEIGHTS, SsqScore, score
from vrcomfort.questionnaire.tables import Sheet, read_long, read_sheets

__all__ = [
    "FMS",
    "INSTRUMENTS",
    "LOADINGS",
    "MISC",
    "SSQ",
    "WEIGHTS",
    "Instrument",
    "Item",
    "Sheet",
    "SsqScore",
    "read_long",
    "read_sheets",
    "score",
    "score_complete_ssq",
    "score_ssq",
]
