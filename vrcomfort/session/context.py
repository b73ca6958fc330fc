"""What all parts of a participant's sessions share, built once and handed to each."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.headset.sound import Speaker
from vrcomfort.operator_interface import ProgressCallback
from vrcomfort.protocol import Protocol, Sequence
from vrcomfort.records import Durability, Machine
from vrcomfort.respondent import Respondent
from vrcomfort.session.clock import Clock
from vrcomfort.session.interfaces import (
    HeadsetFor,
    LoadScene,
    Relay,
    Renderer,
    Watchdog,
)
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.panel_screen import PanelScreen


@dataclass
class Floor:
    """Where the scene's floor is.

    Parameters
    ----------
    offset_m
        How much higher in the scene everybody is than over their own floor.
    """

    offset_m: float = 0.0


@dataclass(frozen=True, kw_only=True)
class SessionContext:
    """Whose sessions these are, and with what they are run; made by `vrcomfort.session.run`.

    Parameters
    ----------
    study
        The study folder.
    sequence
        What the participant meets in which order.
    seed
        Of the study.
    exposure_s
        How long an exposure is shown at most: the protocol's longest, or less.
    screen
        Where questions are asked in the headset, None where they are asked elsewhere.
    ipd_measured_m
        The participant's, as the operator measured it; None where it was not entered.
    durability
        When rows are safe from a power cut.
    jumps
        Whether exposures pass without frames, from one event to the next.
    watchdog
        Closes the records where the headset's runtime hangs.
    operators
        What operators want.
    relay
        Other devices that are told what happens.
    speaker
        Plays the sounds of instructions; None where nothing can be heard.
    floor
        Moves as the height of the eyes is measured.
    """

    protocol: Protocol
    study: Path
    participant: str
    sequence: Sequence
    seed: int
    exposure_s: float
    respondent: Respondent
    headset_for: HeadsetFor
    load_scene: LoadScene
    renderer: Renderer
    clock: Clock
    machine: Machine
    screen: PanelScreen | None
    ipd_measured_m: float | None
    durability: Durability
    progress: ProgressCallback
    jumps: bool
    watchdog: Watchdog
    operators: OperatorControl
    relay: Relay
    speaker: Speaker | None
    floor: Floor = field(default_factory=Floor)

    @property
    def stretch(self) -> float:
        """Return the protocol's seconds for each shown second of the longest exposure."""
        return self.protocol.longest_s / self.exposure_s

    @property
    def panel_stands(self) -> bool:
        """Return whether what is pressed answers a question in the headset."""
        return self.screen is not None and self.screen.quad is not None

    def shown_s(self, scene: str) -> float:
        """Return how long a trial is shown: as its scene or view says, or shortened."""
        return min(self.protocol.length_s(scene), self.exposure_s)
