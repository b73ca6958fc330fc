"""Sees that `simulate` goes on with what its sessions on disk were begun with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from vrcomfort.cli.playback import PlaybackSetup
from vrcomfort.cli.study_setup import RespondentKind
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol

NO_HEADSET = "none"
"""What a manifest calls what is there without frames."""
REMEDY = "go on with the same, or choose another --out"


class ResumeCheck:
    """What decides how a simulated session comes out, but for its participant and its seed.

    Parameters
    ----------
    playback
        None without frames.
    exposure_s
        As asked for; `None` is the protocol's.
    """

    def __init__(
        self, protocol: Protocol, playback: PlaybackSetup | None, exposure_s: float | None
    ) -> None:
        self._protocol = protocol
        self._playback = playback
        self._exposure_s = protocol.shown_s(exposure_s)

    def ends(self, study: Path, name: str) -> list[str]:
        """Return how each recorded session of a participant ended.

        Raises
        ------
        InputError
            If a person was in one, or it was begun with something else than this.
        """
        from vrcomfort.records import read_manifest, recorded_sessions, session_folder

        folders = [session_folder(study, name, each) for each in recorded_sessions(study, name)]
        manifests = {folder: read_manifest(folder) for folder in folders}
        for folder, manifest in manifests.items():
            self._check(folder, manifest)
        return [str(manifest.get("status")) for manifest in manifests.values()]

    def _check(self, folder: Path, manifest: Mapping[str, Any]) -> None:
        if (respondent := manifest.get("respondent")) != RespondentKind.SIMULATED:
            message = f"this session was begun with --respondent {respondent}"
            raise InputError(f"{message}; choose another --out for simulations", file=folder)
        try:
            difference = next(self._differences(manifest), None)
        except (KeyError, TypeError, ValueError) as error:
            file = folder / "manifest.json"
            raise InputError("this manifest is damaged; restore it", file=file) from error
        if difference:
            raise InputError(f"this session was begun with {difference}; {REMEDY}", file=folder)

    def _differences(self, manifest: Mapping[str, Any]) -> Iterator[str]:
        """Say in words what a session has that this one would not have."""
        if manifest["protocol"]["sha256"] != self._protocol.sha256:
            yield "another text of this protocol"
        if (shown_s := manifest["exposure_s"]) != self._exposure_s:
            yield f"exposures of {shown_s:g} s, not {self._exposure_s:g} s"
        if headset := manifest["headset"]:  # a session may end before its first exposure
            yield from self._differences_of(headset)

    def _differences_of(self, headset: Mapping[str, Any]) -> Iterator[str]:
        playback = self._playback
        if (headset["name"] == NO_HEADSET) != (playback is None):
            yield "--no-frames" if playback else "frames"
        if playback is None:
            return
        width, height = headset["image_size_px"]
        if (width, height) != playback.size_px:
            yield f"--size {width}x{height}"
        if headset["refresh_hz"] not in (rates_hz := self._would_be("refresh_hz")):
            yield f"frames at {headset['refresh_hz']:g} Hz, not {rates_hz[0]:g} Hz"
        if headset.get("trace_sha256") not in self._would_be("trace_sha256"):
            yield "another head trace"

    def _would_be(self, fact: str) -> list[Any]:
        return [facts.get(fact) for facts in self._headsets]

    @cached_property
    def _headsets(self) -> list[dict[str, Any]]:
        """What a manifest would say of the headset, by the scene that comes first."""
        from vrcomfort.session import headset_facts

        playback = self._playback
        if playback is None:
            return []
        scenes = [self._protocol.view(name).scene for name in self._protocol.scenes]
        return [headset_facts(playback.standing_in(scene)) for scene in scenes]
