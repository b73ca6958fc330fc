"""Keeps a session's manifest up to date, for the record and for a continuation."""

from __future__ import annotations

from typing import Any, Literal

from vrcomfort.headset.base import Headset
from vrcomfort.protocol import Protocol as StudyProtocol
from vrcomfort.records import Manifest, Recorder
from vrcomfort.records.study import now
from vrcomfort.records.wall_clock import WallClockWatch
from vrcomfort.render.effects.depth_of_field.lens_radius import unlimited
from vrcomfort.respondent import Respondent, SimulatedRespondent


class ManifestWriter:
    """The manifest of one session, written whenever something changes that must survive a crash."""

    def __init__(self, manifest: Manifest, recorder: Recorder, respondent: Respondent) -> None:
        self._manifest = manifest
        self._recorder = recorder
        self._respondent = respondent
        self._headset: Headset | None = None
        self._clock = WallClockWatch()

    def open(self) -> None:
        """Write the manifest, with the memory that a continued session begins with."""
        memory = self._manifest.memory
        if memory is not None and isinstance(self._respondent, SimulatedRespondent):
            self._respondent.recall(memory)
        self.boundary()

    def boundary(self) -> None:
        """Remember the respondent: no exposure is under way, a continuation may begin here."""
        if isinstance(self._respondent, SimulatedRespondent):
            self._manifest.memory = self._respondent.memory()
        self._manifest.under_way = None
        self._write()
        if self._headset is not None:
            self.note_headset(self._headset)

    def begin_exposure(self, **row: Any) -> None:
        """Note the trial under way, which a killed program could not write into ``trials.csv``."""
        self._manifest.under_way = row
        self._write()

    def end_exposure(self, trial: int) -> None:
        """Note the end of an exposure: questions after it have a time limit."""
        self._manifest.exposure_ended = {"trial": trial, "at": now()}
        self.boundary()

    def note_eye_height(self, fact: dict[str, Any]) -> None:
        """Note a measurement of the height of the eyes, and its result."""
        self._manifest.eye_heights.append(fact)
        self._write()

    def miss(self, sentence: str) -> None:
        """Note a questionnaire that was not asked in time; a later sentence says it again."""
        what = sentence.partition(":")[0]
        kept = [each for each in self._manifest.missed_questions if not each.startswith(what)]
        self._manifest.missed_questions = [*kept, sentence]
        self._write()

    def flag(self, sentence: str) -> None:
        """Note a trial with worse timing than the protocol allows."""
        self._manifest.timing_flags.append(sentence)
        self._write()

    def clamp(self, sentence: str) -> None:
        """Note a limit that has shortened a blur."""
        self._manifest.clamps.append(sentence)
        self._write()

    @property
    def ended_early(self) -> Literal["withdrawn", "ended"] | None:
        """Return the reason of an early end of session or study, else None."""
        if self._manifest.status == "withdrawn":
            return "withdrawn"
        return "ended" if self._manifest.status == "ended" else None

    def close(self, status: str, ended: dict[str, str] | None = None) -> None:
        """Note the run's status, and the reason of an early end."""
        manifest = self._manifest
        manifest.ended = ended or manifest.ended
        manifest.status, manifest.finished_at = status, now()
        manifest.frames_not_recorded = self._recorder.frames_not_recorded
        if status != "aborted":
            manifest.memory = manifest.under_way = None
        self._write()

    def note_headset(self, headset: Headset) -> None:
        """Enter the headset; facts that it tells late are entered then."""
        self._headset = headset
        before = self._manifest.headset
        told = {name: fact for name, fact in before.items() if (name, fact) != ("refresh_hz", 0.0)}
        facts = {**headset_facts(headset), **told}  # what was noted first stays
        if facts != before:
            self._manifest.headset = facts
            self._write()

    @property
    def headset(self) -> dict[str, Any]:
        """Return the headset's facts so far; none before the first frame."""
        return self._manifest.headset

    def _write(self) -> None:
        self._manifest.changed_while_recorded = [
            each.sentence for each in self._recorder.external_changes
        ]
        self._manifest.clock_set_back += self._clock.set_back()
        running = self._manifest.status == "running"
        sync = self._recorder.durability == "each_row" or not running
        self._manifest.write(self._recorder.folder, self._recorder.access, sync=sync)


def headset_facts(headset: Headset) -> dict[str, Any]:
    """Return the headset's facts for the manifest."""
    return {
        "name": headset.name,
        "refresh_hz": headset.refresh_hz,
        "image_size_px": list(headset.image_size_px),
        **headset.details,
    }


def limits(protocol: StudyProtocol) -> list[str]:
    """Return the clamps that the conditions put on the stimulus."""
    found = []
    for condition in protocol.conditions:
        if blur := condition.depth_of_field:
            radius = f"{blur.max_radius_percent:g} % of one eye's image width"
            beyond = unlimited(condition)
            limit = beyond.text if beyond else f"circle of confusion at most {radius} (radius)"
            found.append(f"{condition.name}: {limit}")
            if condition.focus.method == "gaze" and condition.focus.without_gaze == "nine_ray":
                found.append(f"{condition.name}: without an eye tracker nine rays ahead find focus")
        centre = condition.gaze_centre
        if condition.centred_on_gaze and centre is not None and centre.without_gaze == "head":
            names = " and ".join(condition.centred_on_gaze)
            found.append(
                f"{condition.name}: without an eye tracker {names} are centred on the head's axis"
            )
        if motion := condition.motion_blur:
            streak = f"{motion.max_radius_percent:g} % of one eye's image width"
            found.append(f"{condition.name}: half a motion streak at most {streak}")
    return found
