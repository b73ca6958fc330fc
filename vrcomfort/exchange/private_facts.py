"""What of a session's manifest may tell who its participant is."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

EPOCH = datetime(2000, 1, 1, tzinfo=UTC)
"""Where moments are moved to: midnight, so that the time of day goes, too."""

_OF_EYES = ("ipd_m",)
_REMOVED = "left out"


@dataclass(frozen=True)
class Moved:
    """How a participant's moments are moved.

    Parameters
    ----------
    first
        Becomes `EPOCH`.
    all_one
        All others become that as well.
    """

    first: datetime
    all_one: bool

    def __call__(self, text: str) -> str:
        """Return a moment, ISO 8601 in UTC."""
        moment = datetime.fromisoformat(text)
        gone = moment - self.first
        return EPOCH.isoformat() if self.all_one else (EPOCH + gone).isoformat(timespec="seconds")


def of_manifest(manifest: dict[str, Any], participant: str, moved: Moved) -> dict[str, Any]:
    """Return a session's manifest for another name, without typed texts, dates and eyes."""
    found = _of_run(manifest, moved)
    found["participant"] = participant
    found["earlier_runs"] = [_of_run(run, moved) for run in manifest.get("earlier_runs", [])]
    found["memory"] = None
    found["eye_heights"] = [
        {**each, "measured_m": None, "offset_m": None} for each in manifest.get("eye_heights", [])
    ]
    if ended := manifest.get("exposure_ended"):
        found["exposure_ended"] = {**ended, "at": moved(ended["at"])}
    if early := manifest.get("ended"):
        found["ended"] = {**early, "reason": _REMOVED}
    if begun := manifest.get("under_way"):
        found["under_way"] = {**begun, "participant": participant}
    found["withdrawals_undone"] = [
        {**each, "at": moved(each["at"]), "reason": _REMOVED}
        for each in manifest.get("withdrawals_undone", [])
    ]
    return found


def _of_run(run: dict[str, Any], moved: Moved) -> dict[str, Any]:
    """Return what every run of a session says of itself."""
    found = dict(run)
    for key in ("started_at", "finished_at"):
        if found.get(key):
            found[key] = moved(found[key])
    if "participant" in found:
        found.pop("participant")
    if found.get("clock_set_back"):
        found["clock_set_back"] = [_REMOVED for _ in found["clock_set_back"]]
    if "ipd_measured_m" in found:
        found["ipd_measured_m"] = None
    if isinstance(found.get("headset"), dict):
        found["headset"] = {k: v for k, v in found["headset"].items() if k not in _OF_EYES}
    return found
