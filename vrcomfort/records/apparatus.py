"""The apparatus of sessions, by their manifests, and its differences within a study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.records.manifest import Machine, versions
from vrcomfort.records.reader import Study

Manifest = Mapping[str, Any]
MOST_NAMED = 4
"""Sessions that a sentence names for each value; of more it counts the rest."""


def _image_size(run: Manifest) -> str:
    size_px = list(run["headset"].get("image_size_px", ()))
    # What stands in for the size in a session that ended before its first exposure is none.
    return "×".join(map(str, size_px)) if size_px != [1, 1] else ""


def _refresh_rate(run: Manifest) -> str:
    """Return the rate in whole hertz: a rate that was measured is never quite the same."""
    rate_hz = run["headset"].get("refresh_hz") or 0.0
    return f"{rate_hz:.0f} Hz" if rate_hz else ""


def _headset(run: Manifest) -> str:
    return str(run["headset"].get("headset") or run["headset"].get("name") or "")


FACTS: Mapping[str, Callable[[Manifest], str]] = {
    "headset": _headset,
    "image size of an eye": _image_size,
    "refresh rate": _refresh_rate,
    "runtime": lambda run: run.get("runtime", ""),
    "GPU": lambda run: run.get("gpu", ""),
    "graphics driver": lambda run: run.get("driver", ""),
    "version of the stimulus": lambda run: str(run.get("stimulus_version") or ""),
    "version of vrcomfort": lambda run: run.get("versions", {}).get("vrcomfort", ""),
    "version of pyopenxr": lambda run: run.get("versions", {}).get("pyopenxr", ""),
}
"""Fact → its value in the manifest of a session or of one of its earlier runs; empty: not known."""
KEYS = {
    "participant", "session", "headset", "runtime", "gpu", "driver", "versions", "earlier_runs",
    "stimulus_version",
}  # fmt: skip
"""Of a manifest, which the facts need."""


def apparatus_of(run: Manifest) -> dict[str, str]:
    """Return the facts that are known of a run of a session."""
    known = {"headset": {}, **run}
    return {fact: value for fact, read in FACTS.items() if (value := read(known))}


def facts_now(machine: Machine, headset: Manifest) -> dict[str, Any]:
    """Return the facts of a run that is about to begin, as its manifest will have them."""
    return {**asdict(machine), "headset": headset, "versions": versions()}


def differences(manifests: Iterable[Manifest]) -> list[str]:
    """Return a sentence, without its full stop, on each fact that sessions differ in."""
    found: dict[str, dict[str, list[str]]] = {fact: {} for fact in FACTS}
    for manifest in manifests:
        name = f"{manifest['participant']}/ses-{manifest['session']}"
        for run in (*manifest.get("earlier_runs", ()), manifest):
            for fact, value in apparatus_of(run).items():
                sessions = found[fact].setdefault(value, [])
                if name not in sessions:
                    sessions.append(name)
    return [_sentence(fact, values) for fact, values in found.items() if len(values) > 1]


def differences_in(study: Path, *planned: Manifest) -> list[str]:
    """Return the sentences on a study's sessions that have a manifest, and on `planned` ones."""
    return differences([*_readable(study), *planned])


def require_stimulus(study: Path, version: int) -> None:
    """Make sure that the pictures of a study's sessions are those of a version of the stimulus.

    Raises
    ------
    InputError
        If a session was shown those of another one.
    """
    for manifest in _readable(study):
        known = manifest.get("stimulus_version") or version
        if known != version:
            of = manifest.get("versions", {}).get("vrcomfort", "")
            raise InputError(
                f"{manifest['participant']}/ses-{manifest['session']} was shown version {known} of "
                f"the stimulus (vrcomfort {of}), and this program draws version {version}: "
                "conditions give other pixels; go on with that version of vrcomfort, or with "
                "--other-stimulus, which is recorded",
                file=study,
            )


def _readable(study: Path) -> Iterator[Manifest]:
    for session in Study(study).sessions if study.is_dir() else ():
        try:
            yield session.manifest
        except InputError:  # verify and status say which
            continue


def _sentence(fact: str, values: Mapping[str, list[str]]) -> str:
    told = "; ".join(f"{value} in {_names(sessions)}" for value, sessions in values.items())
    return f"sessions differ in the {fact}: {told}"


def _names(sessions: list[str]) -> str:
    shown = ", ".join(sessions[:MOST_NAMED])
    rest = len(sessions) - MOST_NAMED
    return f"{shown} and {rest} more" if rest > 0 else shown
