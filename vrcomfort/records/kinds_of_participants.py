"""Whether people or simulated participants are in a study."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.reader import Study
from vrcomfort.records.study import read_participants

SIMULATED = "simulated"


def told_of_the_other_kind(study: Path, *, simulated: bool) -> str:
    """Return a sentence on the participants of the other kind, or nothing where there are none.

    Parameters
    ----------
    simulated
        What the participants are who come now.
    """
    people = (row.participant for row in read_participants(study))
    others = [name for name in people if (is_simulated(study, name) is (not simulated))]
    if not others:
        return ""
    more = f" and {len(others) - 3} more" if len(others) > 3 else ""
    there, here = ("real", "simulated") if simulated else ("simulated", "real")
    return (
        f"this study has {there} participants ({', '.join(others[:3])}{more}) and gets {here} ones "
        "now; reports keep them apart; choose another --out for a study of one kind"
    )


def is_simulated(study: Path, participant: str) -> bool | None:
    """Return whether a participant was simulated; None where no session tells."""
    for session in Study(study).sessions_of(participant):
        try:
            respondent = session.manifest["respondent"]
        except (InputError, KeyError):
            continue
        return bool(respondent == SIMULATED)
    return None
