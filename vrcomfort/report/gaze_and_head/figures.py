"""Figures of gaze and head motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.canvas import Drawing, canvas, lines
from vrcomfort.report.gaze_and_head.results import WHOLE
from vrcomfort.report.palette import colour_of, marker_of

if TYPE_CHECKING:
    from vrcomfort.report.gaze_and_head.results import Looked
    from vrcomfort.report.vocabulary import Vocabulary

_DASHES = ("-", "--", ":", "-.")
_SHOWN = ("yaw_deg", "head_z_m")
_TITLES = {"yaw_deg": "yaw, deg²/Hz", "head_z_m": "forwards and back, m²/Hz"}
MOST_MAPS = 6


def gaze_and_head_figures(found: Looked, words: Vocabulary) -> dict[str, Drawing]:
    """Return name → drawing of what there is."""
    drawn = {}
    if found.zones:
        drawn["gaze_zones"] = _zones(found.zones, words)
    if found.maps:
        drawn["gaze_maps"] = _maps(found, words)
    if found.spectra:
        drawn["head_spectra"] = _spectra(found.spectra, words)
    return drawn


def _zones(rows: list[dict[str, Any]], words: Vocabulary) -> Drawing:
    situations = list(dict.fromkeys(row["situation"] for row in rows))
    with canvas("gaze-zones", 5.0, 3.4) as (figure, drawing):
        axes = figure.add_subplot()
        for condition in dict.fromkeys(row["condition"] for row in rows):
            place = words.place(condition)
            for dash, situation in enumerate(situations):
                mine = [
                    r for r in rows if (r["condition"], r["situation"]) == (condition, situation)
                ]
                label = lines(words.condition(condition), 30)
                axes.plot(
                    [r["zone"] for r in mine], [100 * r["share"] for r in mine],
                    _DASHES[dash % len(_DASHES)], marker=marker_of(place), ms=3.5,
                    color=colour_of(place),
                    label=label if situation == WHOLE else f"{label}, {situation}",
                )  # fmt: skip
        axes.set(xlabel="height of the zone / height of the image", ylabel="time inside, %",
                 ylim=(0, 102), xlim=(0, None))  # fmt: skip
        axes.legend(frameon=False, loc="lower right")
    return drawing


def _maps(found: Looked, words: Vocabulary) -> Drawing:
    names = list(found.maps)[:MOST_MAPS]
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    with canvas("gaze-maps", 2.3 * columns + 0.4, 2.5 * rows) as (figure, drawing):
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for axes in panels[len(names) :]:
            axes.set_axis_off()
        for axes, name in zip(panels, names, strict=False):
            shown = found.maps[name]
            left, right = shown.azimuth_deg[[0, -1]]
            low, high = shown.elevation_deg[[0, -1]]
            extent = (left - 0.5, right + 0.5, low - 0.5, high + 0.5)
            axes.imshow(shown.share, origin="lower", extent=extent, cmap="magma")
            axes.set_title(lines(words.condition(name), 24))
        figure.supxlabel("right, °", fontsize=9)
        figure.supylabel("up, °", fontsize=9)
    return drawing


def _spectra(rows: list[dict[str, Any]], words: Vocabulary) -> Drawing:
    with canvas("head-spectra", 6.4, 3.0) as (figure, drawing):
        for axes, signal in zip(figure.subplots(1, len(_SHOWN)), _SHOWN, strict=True):
            for condition in dict.fromkeys(row["condition"] for row in rows):
                mine = [r for r in rows if (r["condition"], r["signal"]) == (condition, signal)]
                axes.loglog(
                    [r["frequency_hz"] for r in mine],
                    [max(r["density"], 1e-15) for r in mine],
                    color=colour_of(words.place(condition)),
                    label=lines(words.condition(condition), 24),
                )
            axes.set(xlabel="frequency, Hz", title=_TITLES[signal])
        figure.axes[0].legend(frameon=False, loc="lower left")
    return drawing
