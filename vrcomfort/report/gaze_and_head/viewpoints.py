"""Fixation maps from the viewpoint of each scene (Mantiuk et al. 2011, Figure 3)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.ordering import natural
from vrcomfort.stats.gaze_and_head import Map, angles_deg, saliency_map, unit_vectors

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from vrcomfort.report.gaze_and_head.exposures import Seen


@dataclass(frozen=True)
class Viewpoint:
    """The fixations of everybody who looked at a scene from one place.

    Parameters
    ----------
    position_m
        (3,) in the world.
    centre_deg
        Azimuth in the world of the middle of the map: where heads faced on average.
    exposures, elsewhere
        Those in the map, and those in which the head was elsewhere or moved about.
    fixations
        How many; each counts for its length.
    """

    scene: str
    position_m: NDArray[np.float64]
    centre_deg: float
    exposures: int
    elsewhere: int
    fixations: int
    map: Map

    @property
    def facts(self) -> dict[str, Any]:
        """Return everything but the map."""
        return {
            "scene": self.scene,
            "position_m": self.position_m.tolist(),
            "centre_deg": self.centre_deg,
            "exposures": self.exposures,
            "elsewhere": self.elsewhere,
            "fixations": self.fixations,
            "outside": self.map.outside,
        }


def viewpoints(
    exposures: Iterable[tuple[str, Seen]], within_m: float, sigma_deg: float
) -> list[Viewpoint]:
    """Return the map of each scene, of which there are fixations from one place.

    Parameters
    ----------
    exposures
        Scene, and what was seen in it.
    within_m
        How far the median position of a head may be from the median of the scene's, and how far
        from its own the head may be in nine tenths of the frames.
    sigma_deg
        Of the Gaussian that a fixation is spread by.
    """
    scenes: dict[str, list[Seen]] = defaultdict(list)
    for scene, seen in exposures:
        if seen.fixations:
            scenes[scene].append(seen)
    names = sorted(scenes, key=natural)
    found = (_viewpoint(name, scenes[name], within_m, sigma_deg) for name in names)
    return [each for each in found if each is not None]


def _viewpoint(
    scene: str, exposures: list[Seen], within_m: float, sigma_deg: float
) -> Viewpoint | None:
    places = np.array([seen.viewpoint_m for seen in exposures])
    middle = np.median(places, axis=0)
    still = np.array([seen.reach_m for seen in exposures]) <= within_m
    near = still & (np.linalg.norm(places - middle, axis=1) <= within_m)
    here = [seen for seen, is_near in zip(exposures, near, strict=True) if is_near]
    if not here:
        return None
    centre_deg = float(angles_deg(np.sum([seen.forward for seen in here], axis=0)[None])[0][0])
    fixated = [each for seen in here for each in seen.fixations]
    ways = unit_vectors(
        np.array([each.azimuth_deg for each in fixated]),
        np.array([each.elevation_deg for each in fixated]),
    )
    seconds = np.array([each.duration_s for each in fixated])
    shown = saliency_map(ways, seconds, centre_deg=centre_deg, sigma_deg=sigma_deg)
    return Viewpoint(
        scene, middle, centre_deg, len(here), len(exposures) - len(here), len(fixated), shown
    )
