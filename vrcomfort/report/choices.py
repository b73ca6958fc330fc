"""What people chose where a questionnaire asked which of several conditions."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

from vrcomfort.errors import InputError
from vrcomfort.report.ordering import natural
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Sheet
    from vrcomfort.report.study_data import StudyData

_Met = dict[tuple[str, str], list[dict[str, str]]]


def choices_of(study: StudyData, item: str) -> dict[str, list[str | None]]:
    """Return participant → the conditions that they chose, None for no preference.

    Answers 1, 2, … are the first, the second, … way of rendering, as the participant met them: of
    the last exposures where the question is of a trial, else of the session, or (where that has
    not as many) of all sessions until then.

    Parameters
    ----------
    item
        ``instrument.item``.

    Raises
    ------
    InputError
        If there is no such question, or an answer means none of the conditions that were met.
    """
    instrument, _, name = item.partition(".")
    sheets = [s for s in study.sheets if _instrument(s) == instrument and name in s.answers]
    if not sheets:
        asked = {f"{_instrument(s)}.{each}" for s in study.sheets for each in s.answers}
        raise InputError(f"no question `{item}` was answered; {did_you_mean(item, asked)}")
    met: _Met = defaultdict(list)
    for trial in sorted(study.trials, key=lambda row: natural(row["trial"])):
        met[trial["participant"], trial["session"]].append(trial)
    high = int(study.instruments[instrument].item(name).answers.high)  # type: ignore[union-attr]
    found: dict[str, list[str | None]] = {sheet.participant: [] for sheet in sheets}
    for sheet in sheets:
        answer = sheet.answers[name]
        if answer is None:
            continue
        if answer == 0:
            found[sheet.participant].append(None)
            continue
        conditions = _compared(sheet, met, high)
        if not 1 <= answer <= len(conditions):
            message = f"{sheet.place}: {sheet.participant} chose {answer} of {len(conditions)}"
            raise InputError(f"{message} conditions met until then; trials.csv lacks exposures")
        found[sheet.participant].append(conditions[int(answer) - 1])
    return found


def _instrument(sheet: Sheet) -> str:
    return sheet.keys.get("instrument", "")


def _compared(sheet: Sheet, met: _Met, high: int) -> list[str]:
    """Return the conditions that answers 1, 2, … mean."""
    trials = met.get((sheet.participant, sheet.session), [])
    if sheet.trial:
        until = [t for t in trials if natural(t["trial"]) <= natural(sheet.trial)]
        return [t["condition"] for t in until[-high:]]
    conditions = list(dict.fromkeys(t["condition"] for t in trials))
    if len(conditions) == high:
        return conditions
    sessions = sorted({s for who, s in met if who == sheet.participant}, key=natural)
    before = [s for s in sessions if natural(s) <= natural(sheet.session)]
    every = [t["condition"] for s in before for t in met[sheet.participant, s]]
    return list(dict.fromkeys(every))
