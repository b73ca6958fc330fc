"""``manifest.json``: the facts of a session that its stimuli depend on."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.records.disk import OWNER, Access, replace_text
from vrcomfort.records.json_file import ManifestShape, indented, read_json
from vrcomfort.records.schema import SCHEMA_VERSION

# Of those installed, the ones whose version can change a picture or a file.
_PACKAGES = ("vrcomfort", "numpy", "moderngl", "pydantic", "pillow", "pyopenxr")


@dataclass(frozen=True)
class Machine:
    """The machine, renderer and headset of a session, as the command line found them.

    Parameters
    ----------
    shaders
        file → SHA-256.
    passes
        condition in scene → names of the passes, in order.
    stimulus_version
        Of the pictures that conditions give (`frame.STIMULUS_VERSION`); 0 where it is not known.
    text_layout
        What drew the text of panels: layout engine, FreeType, and font → version.
    timing_trust
        How far the times in ``frames.csv`` are those of a display: "lockstep" for playback,
        "runtime" where a compositor predicted them.
    """

    gpu: str = ""
    driver: str = ""
    runtime: str = ""
    shaders: Mapping[str, str] = field(default_factory=dict)
    passes: Mapping[str, list[str]] = field(default_factory=dict)
    text_layout: Mapping[str, str] = field(default_factory=dict)
    timing_trust: str = "lockstep"
    stimulus_version: int = 0


@dataclass
class Manifest:
    """The manifest of one session; rewritten when the session ends.

    Parameters
    ----------
    exposure_s
        How long an exposure was shown at most: the protocol's longest, or the override.
    clamps
        Every clamp that touched the stimulus, one sentence each.
    earlier_runs
        The same facts about each run of the session that was interrupted, in order.
    timing_flags
        Trials that dropped more frames than the protocol allows, one sentence each.
    frames_not_recorded
        Frames of this run without a row in ``frames.csv``: the disk was too slow.
    changed_while_recorded
        What other programs have done to the files of this run, one sentence each.
    under_way
        Trial, attempt and start of the exposure that has begun and not ended.
    ipd_measured_m
        The participant's distance between the pupils, if it was entered; ``headset`` has the one
        that was shown, ``settings`` the one that the protocol wishes.
    exposure_ended
        Number of the trial that ended last, and when on the wall clock.
    missed_questions
        Questionnaires that an interruption cut off and that were not asked in time, a sentence
        each.
    withdrawals_undone
        Withdrawals that an operator took back: when, why, and in which attempt at which trial.
    clock_set_back
        Where the machine's clock stood earlier than before, one sentence each.
    memory
        What the respondent was like at the last boundary between exposures; None when done.
    ended
        What ended the session before its time (``by``: participant, rating, score, gaze,
        practice), whether the session or the study (``ends``), and the ``reason``; else None.
    eye_heights
        Each measurement: ``before_trial``, ``measured_m`` over the participant's floor, and
        ``offset_m``, how much higher they were in the scene.
    preflight
        The checks before the session (``at``, ``outcome``), or the reason why none held
        (``without``); None where none is asked for: playback, simulated participants, rehearsals.
    sees_sharp
        The eyes with which the participant sees sharp, if it was entered.
    """

    participant: str
    session: int
    sequence: str
    protocol: Protocol
    machine: Machine
    headset: dict[str, Any]
    respondent: str
    seed: int
    exposure_s: float
    started_at: str
    status: str = "running"
    finished_at: str | None = None
    clamps: list[str] = field(default_factory=list)
    earlier_runs: list[dict[str, Any]] = field(default_factory=list)
    timing_flags: list[str] = field(default_factory=list)
    frames_not_recorded: int = 0
    changed_while_recorded: list[str] = field(default_factory=list)
    ipd_measured_m: float | None = None
    clock_set_back: list[str] = field(default_factory=list)
    under_way: dict[str, Any] | None = None
    exposure_ended: dict[str, Any] | None = None
    missed_questions: list[str] = field(default_factory=list)
    withdrawals_undone: list[dict[str, Any]] = field(default_factory=list)
    memory: dict[str, Any] | None = None
    ended: dict[str, str] | None = None
    eye_heights: list[dict[str, Any]] = field(default_factory=list)
    preflight: dict[str, str] | None = None
    sees_sharp: str | None = None

    def write(self, folder: Path, access: Access = OWNER, *, sync: bool = True) -> None:
        """Write ``manifest.json`` as a whole; it is on the disk at return, if `sync`.

        Raises
        ------
        InputError
            If the disk refuses.
        """
        text = indented(self._content())
        replace_text(folder / "manifest.json", text + "\n", access, sync=sync)

    def _content(self) -> dict[str, Any]:
        protocol = self.protocol
        overridden = self.exposure_s != protocol.longest_s
        return {
            "schema_version": SCHEMA_VERSION,
            "participant": self.participant,
            "session": self.session,
            "sequence": self.sequence,
            "status": self.status,
            "started_at": self.started_at,
            "finished_at": self.finished_at,
            "seed": self.seed,
            "respondent": self.respondent,
            "language": protocol.language,
            "wordings": protocol.wordings,
            "headset": self.headset,
            "ipd_measured_m": self.ipd_measured_m,
            "sees_sharp": self.sees_sharp,
            "preflight": self.preflight,
            "exposure_s": self.exposure_s,
            "exposure_override_s": self.exposure_s if overridden else None,
            "clamps": self.clamps,
            "timing_flags": self.timing_flags,
            "frames_not_recorded": self.frames_not_recorded,
            "changed_while_recorded": self.changed_while_recorded,
            "clock_set_back": self.clock_set_back,
            **asdict(self.machine),
            "versions": versions(),
            "task_code": protocol.task_code,
            **self._of_protocol,
            "earlier_runs": self.earlier_runs,
            "under_way": self.under_way,
            "exposure_ended": self.exposure_ended,
            "missed_questions": self.missed_questions,
            "withdrawals_undone": self.withdrawals_undone,
            "memory": self.memory,
            "ended": self.ended,
            "eye_heights": self.eye_heights,
        }

    @cached_property
    def _of_protocol(self) -> dict[str, Any]:
        """Return the manifest's facts of the protocol, which does not change."""
        protocol = self.protocol
        return {
            "protocol": {
                "name": protocol.name,
                "file": protocol.file.name if protocol.file else None,
                "sha256": protocol.sha256,
                "text": protocol.toml,
                "parts": [
                    {"file": Path(file).name, "sha256": sha256}
                    for file, sha256 in protocol.included.items()
                ],
                "media": protocol.media,
            },
            "settings": protocol.model_dump(mode="json"),
        }


_OF_THE_SESSION = (
    "schema_version",
    "participant", "session", "sequence", "seed", "exposure_s", "exposure_override_s", "protocol",
    "settings", "timing_flags", "earlier_runs", "under_way", "exposure_ended", "missed_questions",
    "withdrawals_undone", "memory", "ended", "language", "wordings", "eye_heights", "sees_sharp",
)  # fmt: skip


def facts_of_run(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a manifest's facts of its last run, for the run that continues the session.

    A run that had no time to write how it ended was killed.
    """
    facts = {key: value for key, value in content.items() if key not in _OF_THE_SESSION}
    return facts | {"status": "killed"} if facts.get("status") == "running" else facts


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the content of a session's ``manifest.json``.

    Raises
    ------
    InputError
        If it is not there, damaged, or that of another session.
    """
    file = folder / "manifest.json"
    content = read_json(file, ManifestShape, "manifest")
    whose = f"sub-{content['participant']}", f"ses-{content['session']}"
    if whose != (folder.parent.name, folder.name):
        raise InputError(f"this manifest is that of {'/'.join(whose)}; restore it", file=file)
    return content


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that shape the stimulus."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    """Look the versions up: once, for that reads the files of many packages."""
    found = {"python": platform.python_version(), "platform": platform.platform()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
