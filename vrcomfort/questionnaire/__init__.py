"""Questionnaires: instruments, their answers in files, and scoring."""

from vrcomfort.questionnaire.answers import Answer, Answers
from vrcomfort.questionnaire.instrument_file import (
    InstrumentTable,
    instrument_in,
    parse_instrument,
    read_instrument,
    short_form,
)
from vrcomfort.questionnaire.instruments import Instrument, Item, plain
from vrcomfort.questionnaire.library import (
    FOLDER,
    asked_in,
    find_instrument,
    guess,
    guess_for_file,
    instruments_in,
    shipped_instruments,
    usual_instruments,
)
from vrcomfort.questionnaire.scales import Scale
from vrcomfort.questionnaire.scoring import Score, score, score_all, score_file, score_sheets
from vrcomfort.questionnaire.tables import Sheet, never_zero, read_long, read_sheets

__all__ = [
    "FOLDER",
    "Answer",
    "Answers",
    "Instrument",
    "InstrumentTable",
    "Item",
    "Scale",
    "Score",
    "Sheet",
    "asked_in",
    "find_instrument",
    "guess",
    "guess_for_file",
    "instrument_in",
    "instruments_in",
    "never_zero",
    "parse_instrument",
    "plain",
    "read_instrument",
    "read_long",
    "read_sheets",
    "score",
    "score_all",
    "score_file",
    "score_sheets",
    "shipped_instruments",
    "short_form",
    "usual_instruments",
]
