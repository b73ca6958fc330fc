"""Figures, CSV tables and methods paragraphs of gaze and head motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FuncFormatter

from vrcomfort.report.analyses.contract import MethodsParagraph
from vrcomfort.report.canvas import INK, Drawing, canvas, lines
from vrcomfort.report.gaze_and_head.analysis import EVERYBODY
from vrcomfort.report.gaze_and_head.exposures import WHOLE
from vrcomfort.report.palette import colour_of, marker_of
from vrcomfort.report.rows import Cells, as_json

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes

    from vrcomfort.report.gaze_and_head.analysis import GazeAndHeadAnalysis
    from vrcomfort.report.gaze_and_head.settings import GazeAndHead
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.gaze_and_head import Map

_DASHES = ("-", "--", ":", "-.")
_SHOWN = ("yaw_deg", "head_z_m")
_TITLES = {"yaw_deg": "Yaw, deg²/Hz", "head_z_m": "Forwards and back, m²/Hz"}
_MAP_COLOURS = "magma"
_DECADES_SHOWN = 1e8
"""Of densities: what is smaller than the largest by more than this is rounding."""
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MOST_MAPS = 6


def gaze_and_head_figures(found: GazeAndHeadAnalysis, words: Vocabulary) -> dict[str, Drawing]:
    """Return name → drawing of the figures with data."""
    drawn = {}
    if found.zones:
        drawn["gaze_zones"] = _zones(found, words)
    if found.maps:
        maps = {words.condition(name): shown for name, shown in found.maps.items()}
        right = "to the right of the head’s axis, °"
        drawn["gaze_maps"] = _maps("gaze-maps", maps, right, "gaze_maps")
    if found.viewpoints:
        maps = {each.row.scene: each.map for each in found.viewpoints}
        drawn["gaze_fixations"] = _maps(
            "gaze-fixations", maps, "to the right of the middle, °", "fixations"
        )
    if found.spectra:
        drawn["head_spectra"] = _spectra(found, words)
    return drawn


def _zones(found: GazeAndHeadAnalysis, words: Vocabulary) -> Drawing:
    """Draw a curve for each situation, and of each event's time; all situations together in ink."""
    events = list(dict.fromkeys(row.during for row in found.zones))
    situations = list(dict.fromkeys(row.situation for row in found.zones))
    with canvas("gaze-zones", 6.6, 3.6, "gaze_zones") as (figure, drawing):
        axes = figure.add_subplot()
        for place, situation in enumerate(situations):
            of_all = situation == EVERYBODY
            label = "all" if of_all else lines(words.condition(situation), 28)
            for dash, event in enumerate(events):
                mine = [r for r in found.zones if (r.situation, r.during) == (situation, event)]
                if not mine:  # nobody shoots while they look around
                    continue
                axes.plot(
                    [r.zone for r in mine], [100 * r.share for r in mine],
                    _DASHES[dash % len(_DASHES)], ms=3.5, lw=2.2 if of_all else 1.4,
                    marker="" if of_all else marker_of(place),
                    color=INK if of_all else colour_of(place),
                    label=label if event == WHOLE else f"{label}, {lines(event, 28)}",
                )  # fmt: skip
        axes.set(xlabel="height of the zone / height of the image", ylabel="time inside, %",
                 ylim=(0, 102), xlim=(0, None))  # fmt: skip
        axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return drawing


def _maps(name: str, maps: dict[str, Map], across: str, *tables: str) -> Drawing:
    """Draw maps side by side, with one scale of brightness."""
    names = list(maps)[:MOST_MAPS]
    columns = 2 if len(names) == 4 else min(3, len(names))
    rows = -(-len(names) // columns)
    brightest = max(float(maps[each].share.max()) for each in names)
    with canvas(name, 2.3 * columns + 0.5, 2.7 * rows + 0.3, *tables) as (figure, drawing):
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for axes in panels[len(names) :]:
            axes.set_axis_off()
        for axes in panels[len(names) - columns : len(names)]:
            axes.tick_params(labelbottom=True)
        for axes, title in zip(panels, names, strict=False):
            _map(axes, maps[title], brightest)
            axes.set_title(lines(title, 24))
        figure.supxlabel(across, fontsize=9)
        figure.supylabel("up, °", fontsize=9)
    return drawing


def _map(axes: Axes, shown: Map, brightest: float) -> None:
    left, right = shown.azimuth_deg[[0, -1]]
    low, high = shown.elevation_deg[[0, -1]]
    half = (shown.azimuth_deg[1] - left) / 2
    extent = (left - half, right + half, low - half, high + half)
    axes.imshow(
        shown.share, origin="lower", extent=extent, cmap=_MAP_COLOURS, vmin=0, vmax=brightest
    )


def _spectra(found: GazeAndHeadAnalysis, words: Vocabulary) -> Drawing:
    situations = list(dict.fromkeys(row.situation for row in found.spectra))
    with canvas("head-spectra", 6.8, 3.2, "head_spectra") as (figure, drawing):
        for axes, signal in zip(figure.subplots(1, len(_SHOWN)), _SHOWN, strict=True):
            for place, situation in enumerate(situations):
                mine = [r for r in found.spectra if (r.situation, r.signal) == (situation, signal)]
                axes.loglog(
                    [r.frequency_hz for r in mine],
                    [r.density or None for r in mine],
                    color=colour_of(place),
                    label=lines(words.condition(situation), 24),
                )
            top = max((r.density for r in found.spectra if r.signal == signal), default=1.0)
            axes.set(
                xlabel="frequency, Hz", title=_TITLES[signal],
                ylim=(top / _DECADES_SHOWN, 3 * top) if top else None,
            )  # fmt: skip
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.yaxis.set_major_formatter(FuncFormatter(_power_of_ten))
            axes.minorticks_off()
        figure.axes[0].legend(frameon=False, loc="upper right")
    return drawing


def _power_of_ten(value: float, _: int) -> str:
    """Return a tick's label; the style of the report has no formulae."""
    power = str(round(np.log10(value))) if value > 0 else ""
    return f"10{power.translate(_SUPERSCRIPTS)}" if power else ""


def gaze_and_head_tables(found: GazeAndHeadAnalysis) -> dict[str, list[Cells]]:
    """Return name → lines of the CSV tables."""
    return {
        "gaze_and_head": as_json(found.exposures),
        "gaze_zones": as_json(found.zones),
        "gaze_maps": [
            line for name, shown in found.maps.items() for line in _cells_of(name, shown)
        ],
        "gaze_nodes": as_json(found.nodes),
        "fixations": as_json(found.fixations),
        "head_spectra": as_json(found.spectra),
    }


def _cells_of(situation: str, shown: Map) -> Iterator[Cells]:
    """Yield the cells of a map that were looked at."""
    for row, column in zip(*np.nonzero(shown.share), strict=True):
        yield {
            "situation": situation,
            "azimuth_deg": float(shown.azimuth_deg[column]),
            "elevation_deg": float(shown.elevation_deg[row]),
            "share": float(shown.share[row, column]),
        }


def gaze_paragraphs(found: GazeAndHeadAnalysis) -> Iterator[MethodsParagraph]:
    """Yield the paragraphs of the methods section."""
    asked = found.asked
    if asked is None or not found.exposures:
        return
    if any(row.gaze_valid_share for row in found.exposures):
        yield _gaze_paragraph(asked, found)
    yield _head_paragraph(asked)


def _gaze_paragraph(asked: GazeAndHead, found: GazeAndHeadAnalysis) -> MethodsParagraph:
    rule = (
        f"slower than {asked.velocity_deg_s:g}° per second from sample to sample (I-VT"
        if asked.fixations == "i_vt"
        else f"within a dispersion of {asked.dispersion_deg:g}° (I-DT"
    )
    text = (
        "The gaze is the headset’s, in the frames in which it was valid, and counts for each "
        "frame’s period. A centred zone of ratio r has r times the height and width of an eye’s "
        "image (Hillaire et al., 2008). Fixations are stretches of the line of sight in the world "
        f"{rule}; Salvucci & Goldberg, 2000), of at least {asked.shortest_fixation_s:g} s. "
    )
    cited = ["hillaire_2008", "salvucci_2000"]
    if found.viewpoints:
        text += (
            "Fixation maps are those of exposures that were seen from one place (Mantiuk et al., "
            "2011); each fixation counts for its length. "
        )
        cited.append("mantiuk_2011")
    if found.shown:
        text += (
            "What was looked at is the node of the scene that the line of sight meets first; a "
            "node’s share is of the time in which the gaze was known and the scene drawn. "
        )
    return MethodsParagraph("Gaze", f"{text}Every person counts alike.", tuple(cited))


def _head_paragraph(asked: GazeAndHead) -> MethodsParagraph:
    text = (
        "Spectra of the head’s position and orientation in the stage are Welch’s (1967), with Hann "
        f"windows of {asked.spectrum_window_s:g} s that overlap by half and are without their "
        "means. Dropped frames are filled by linear interpolation; a gap of more than four "
        "refreshes, or a jump, ends a stretch."
    )
    return MethodsParagraph("Head motion", text, ("welch_1967",))
