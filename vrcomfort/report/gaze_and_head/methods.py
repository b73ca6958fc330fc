"""What the methods section says of gaze and head motion."""

from __future__ import annotations

from typing import Any

Results = dict[str, Any]
Paragraph = tuple[str, str, tuple[str, ...]]
"""Title, text, and the keys of what it cites."""


def gaze_paragraphs(results: Results) -> list[Paragraph]:
    """Return the paragraphs on what this report holds of these."""
    found = results["gaze_and_head"]
    if not found or not found["exposures"]:
        return []
    asked = results["plan"]["gaze_and_head"]
    seen = any(row["gaze_valid_share"] for row in found["exposures"])
    return [*([_gaze(asked, found)] if seen else []), _head(asked)]


def _gaze(asked: Results, found: Results) -> Paragraph:
    rule = (
        f"slower than {asked['velocity_deg_s']:g}° per second from sample to sample (I-VT"
        if asked["fixations"] == "i_vt"
        else f"within a dispersion of {asked['dispersion_deg']:g}° (I-DT"
    )
    text = (
        "The gaze is the headset’s, in the frames in which it was valid, and counts for each "
        "frame’s period. A centred zone of ratio r has r times the height and width of an eye’s "
        "image (Hillaire et al., 2008). Fixations are stretches of the line of sight in the world "
        f"{rule}; Salvucci & Goldberg, 2000), of at least {asked['shortest_fixation_s']:g} s. "
    )
    cited = ["hillaire_2008", "salvucci_2000"]
    if found["viewpoints"]:
        text += (
            "Fixation maps are those of exposures that were seen from one place (Mantiuk et al., "
            "2011); each fixation counts for its length. "
        )
        cited.append("mantiuk_2011")
    if found["nodes"]:
        text += (
            "What was looked at is the node of the scene that the line of sight meets first; a "
            "node’s share is of the time in which the gaze was known and the scene drawn. "
        )
    return "Gaze", f"{text}Every person counts alike.", tuple(cited)


def _head(asked: Results) -> Paragraph:
    text = (
        "Spectra of the head’s position and orientation in the stage are Welch’s (1967), with Hann "
        f"windows of {asked['spectrum_window_s']:g} s that overlap by half and are without their "
        "means. Dropped frames are filled by linear interpolation; a gap of more than four "
        "refreshes, or a jump, ends a stretch."
    )
    return "Head motion", text, ("welch_1967",)
