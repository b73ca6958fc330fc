"""The figures of a report, and those of participant flow, symptoms, recovery and exposures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from vrcomfort.records.names import natural
from vrcomfort.report import palette
from vrcomfort.report.analyses import analysis_figures
from vrcomfort.report.analyses.signed_rank.figure import estimation_figure
from vrcomfort.report.canvas import (
    FAINT,
    GRID,
    INK,
    LEGEND,
    PAPER,
    SOFT,
    Drawing,
    canvas,
    dots,
    lines,
    short,
    spread,
    threads,
    time_unit,
)
from vrcomfort.report.palette import colour_of, marker_of
from vrcomfort.report.residuals import residual_figure, residual_lines
from vrcomfort.report.sections import section_figures
from vrcomfort.report.study_data import trial_s
from vrcomfort.report.symptoms import recovery_course

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from vrcomfort.report.analyses import ReportContext
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.flow import FlowLoss, FlowStage
    from vrcomfort.report.residuals import Residuals
    from vrcomfort.report.results import Results
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.sections import Section
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.symptoms import RecoveryRow, SymptomRow
    from vrcomfort.report.vocabulary import Vocabulary


MOST_PEOPLE = 60
"""People whose exposures are drawn one by one; of more, those who withdrew come first."""


def draw_figures(
    study: StudyData,
    results: Results,
    scored: Exposures,
    residuals: list[Residuals],
    sections: list[Section],
    report: ReportContext,
) -> dict[str, Drawing]:
    """Return name → drawing of every figure that the data allow."""
    drawn: dict[str, Drawing | None] = {}
    words, wanted = report.words, results.plan.figures
    for place, outcome in enumerate(words.outcomes):
        if _wanted(wanted, "subscales" if place else "paired"):
            tests = [test for test in results.tests if test.outcome == outcome]
            drawn[f"estimation_{outcome}"] = estimation_figure(scored, tests, words)
    of_analyses = [
        (each, of_outcome)
        for of_outcome, each in analysis_figures(results.rows, report)
        if _wanted(wanted, each.kind)
    ]
    drawn |= {each.name: each.draw(scored) for each, of_outcome in of_analyses if of_outcome}
    drawn["flow"] = flow_figure(results.flow)
    for instrument in dict.fromkeys(row.instrument for row in results.symptoms):
        rows = [row for row in results.symptoms if row.instrument == instrument]
        drawn[f"symptoms_{instrument}"] = symptom_figure(rows, instrument, words)
    drawn["recovery"] = recovery_figure(scored, results.recovery_course, words)
    withdrew = {each.participant for each in results.withdrawals.list}
    drawn["exposures"] = exposure_figure(list(study.trials), withdrew, words)
    drawn["residuals"] = residual_figure(residuals, words)
    drawn |= section_figures(sections, words)
    chosen = {each.name for each, _ in of_analyses}
    drawn |= {each.name: each.draw(scored) for each, of_outcome in of_analyses if not of_outcome}
    return {
        name: drawing
        for name, drawing in drawn.items()
        if drawing and (name in chosen or name.startswith(_OTHERWISE) or _wanted(wanted, name))
    }


_OTHERWISE = ("estimation_", "flow")
"""Figures that every plan has, or that were chosen before they were drawn."""


def _wanted(wanted: Sequence[str], name: str) -> bool:
    """Return whether a plan wants a figure: every one, where it names none."""
    return not wanted or name.partition("_")[0] in wanted


def symptom_figure(
    symptoms: list[SymptomRow], instrument: str, words: Vocabulary
) -> Drawing | None:
    """Draw the mean answer of each symptom by condition, the largest first."""
    means: dict[str, dict[str, float]] = {}
    for row in symptoms:
        means.setdefault(row.item, {})[row.condition] = row.mean
    if not means:
        return None
    ranked = sorted(means, key=lambda item: max(means[item].values()))
    shown = [c for c in words.conditions if any(c in found for found in means.values())]
    with canvas(f"symptoms-{instrument}", 6.4, 1.1 + 0.22 * len(ranked), "symptoms") as (
        figure,
        drawing,
    ):
        axes = figure.add_subplot()
        for line, item in enumerate(ranked):
            values = list(means[item].values())
            axes.plot([min(values), max(values)], [line, line], color=GRID, lw=2, zorder=1)
        for index, condition in enumerate(shown):
            rows = np.arange(len(ranked)) + 0.5 / len(shown) * ((len(shown) - 1) / 2 - index)
            place = words.place(condition)
            axes.plot([means[item].get(condition, np.nan) for item in ranked], rows,
                      marker_of(place), color=colour_of(place), ms=6, mec=PAPER, mew=0.6,
                      label=lines(words.condition(condition), LEGEND), zorder=3)  # fmt: skip
        wording = [lines(words.item(instrument, item), 44) for item in ranked]
        axes.set_yticks(range(len(ranked)), wording)
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x", color=GRID)
        axes.set_axisbelow(True)
        axes.set_xlabel(f"mean answer ({words.answers(instrument)}), {words.basis}")
        axes.axvline(0, color=FAINT, lw=0.8, zorder=0)
        axes.legend(frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    return drawing


def recovery_figure(
    scored: Exposures, rows: list[RecoveryRow], words: Vocabulary
) -> Drawing | None:
    """Draw scores after a session's last exposure and after recovery; a line is a session."""
    if not rows:
        return None
    outcome = rows[0].outcome
    scores = np.column_stack(recovery_course(scored, outcome))
    with canvas("recovery", 3.4, 3.2, "recovery_scores") as (figure, drawing):
        axes = figure.add_subplot()
        threads(axes, np.array([0.0, 1.0]), scores, color=FAINT, lw=0.8, alpha=0.6)
        for place in (0, 1):
            across = place + spread(len(scores), 0.03 if len(scores) > 12 else 0.0)
            dots(axes, across, scores[:, place], SOFT, size=3.4, alpha=0.7)
        means = scores.mean(axis=0)
        axes.plot([0, 1], means, "-D", color=INK, ms=6, lw=2, mec=PAPER, mew=0.8, zorder=5)
        axes.set_xticks([0, 1], ["after the last\nexposure", "after\nrecovery"])
        axes.set_xlim(-0.35, 1.35)
        axes.set_ylabel(f"{words.outcome(outcome)}, {words.basis}")
        axes.axhline(0, color=SOFT, lw=0.8, ls=(0, (4, 3)), zorder=0)
    return drawing


def figure_tables(
    study: StudyData, results: Results, scored: Exposures, residuals: list[Residuals]
) -> dict[str, list[Cells]]:
    """Return the lines of the CSV tables that figures alone are drawn from."""
    recovered: list[Cells] = []
    if results.recovery_course:
        outcome = results.recovery_course[0].outcome
        pairs = zip(*(each.tolist() for each in recovery_course(scored, outcome)), strict=True)
        recovered = [{"outcome": outcome, "exposed": x, "recovered": y} for x, y in pairs]
    columns = ("participant", "session", "trial", "condition", "scene", "status")
    shown: list[Cells] = [
        {**{name: trial.get(name) for name in columns}, "shown_s": trial_s(trial)}
        for trial in study.trials
    ]
    return {
        "recovery_scores": recovered,
        "exposures": shown if results.withdrawals.n else [],
        "residuals": residual_lines(residuals),
    }


def exposure_figure(
    trials: list[dict[str, str]], withdrew: set[str], words: Vocabulary
) -> Drawing | None:
    """Draw the exposures of people in order, with a cross at withdrawals; None without any."""
    if not withdrew or not trials:
        return None
    everybody = sorted({t["participant"] for t in trials}, key=natural)
    first = sorted(everybody, key=lambda who: who not in withdrew)[:MOST_PEOPLE]
    people = [who for who in everybody if who in set(first)]
    of: dict[str, list[dict[str, str]]] = {who: [] for who in people}
    for trial in trials:
        if trial["participant"] in of:
            of[trial["participant"]].append(trial)
    with canvas("exposures", 6.8, 0.9 + 0.19 * len(people), "exposures") as (figure, drawing):
        axes = figure.add_subplot()
        scale, unit = time_unit(max(trial_s(t) or 0.0 for t in trials))
        for row, who in enumerate(reversed(people)):
            mine = sorted(of[who], key=lambda t: (natural(t["session"]), natural(t["trial"])))
            _exposures_of(axes, row, mine, words, scale, withdrew=who in withdrew)
        _legend_of_exposures(axes, words)
        axes.set_yticks(range(len(people)), [*map(short, reversed(people))], fontsize=7.5)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel(f"time in exposure, all sessions ({unit})")
        axes.xaxis.set_major_locator(MaxNLocator(nbins=8))
    return drawing


def _legend_of_exposures(axes: Axes, words: Vocabulary) -> None:
    for place, label in enumerate(words.conditions.values()):
        axes.barh(0, 0, color=colour_of(place), alpha=0.8, label=lines(label, LEGEND))
    axes.plot([], [], "X", color=INK, ms=7, ls="", label="withdrew here")
    columns = 3 if len(words.conditions) < 3 else 2
    axes.legend(frameon=False, ncols=columns, loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)


def _exposures_of(
    axes: Axes, row: int, trials: list[dict[str, str]], words: Vocabulary, scale: float, *,
    withdrew: bool,
) -> None:  # fmt: skip
    start = 0.0
    for trial in trials:
        length = (trial_s(trial) or 0.0) / scale
        known = trial["condition"] in words.conditions
        colour = colour_of(words.place(trial["condition"])) if known else FAINT
        axes.barh(row, length, left=start, height=0.62, color=colour, alpha=0.8,
                  edgecolor=PAPER, lw=1.2)  # fmt: skip
        start += length
    if withdrew:
        axes.plot(start, row, "X", color=INK, ms=7, mec=PAPER, mew=0.8, zorder=5)


_WIDTH_IN, _LINE_IN, _GAP_IN = 6.2, 0.19, 0.16
_MAIN, _SIDE = (0.0, 2.0), (2.7, 3.5)
"""Left edge and width of the boxes of stages and of reasons, in inches."""


def flow_figure(flow: list[FlowStage]) -> Drawing:
    """Draw the stages below each other, with losses and their reasons between them."""
    parts: list[tuple[str, str]] = []
    for stage in flow:
        parts.append(("stage", _stage(stage)))
        if stage.left:
            parts.append(("reasons", _reasons(stage.left)))
    heights = [_height(text) for _, text in parts]
    total = sum(heights) + _GAP_IN * (len(parts) + 1)
    with canvas("flow", _WIDTH_IN, total, "flow") as (figure, drawing):
        axes = figure.add_subplot()
        axes.set_xlim(-0.05, _WIDTH_IN)
        axes.set_ylim(-total, 0)
        axes.axis("off")
        middle, top, before = _MAIN[0] + _MAIN[1] / 2, -_GAP_IN, 0.0
        for (kind, text), height in zip(parts, heights, strict=True):
            if kind == "stage":
                if before:
                    _arrow(axes, (middle, before), (middle, top))
                _box(axes, _MAIN, top, height, text, palette.BOX.light)
                before = top - height
            else:
                _arrow(axes, (middle, top - height / 2), (_SIDE[0], top - height / 2))
                _box(axes, _SIDE, top, height, text, "none")
            top -= height + _GAP_IN
    return drawing


def _stage(stage: FlowStage) -> str:
    text, counts = f"{stage.stage}\nn = {stage.n}", stage.analysed
    if counts and counts.again:
        text += f"\n{counts.again} of them withdrew"
    if counts and counts.in_every_test != stage.n:
        text += f"\n{counts.in_every_test} in every test"
    return text


def _reasons(losses: list[FlowLoss]) -> str:
    return "\n".join(lines(f"{loss.n}: {loss.reason}", 46) for loss in losses)


def _height(text: str) -> float:
    return _LINE_IN * (text.count("\n") + 1) + 0.16


def _box(
    axes: Axes, across: tuple[float, float], top: float, height: float, text: str, face: str
) -> None:

    axes.add_patch(
        Rectangle((across[0], top - height), across[1], height, fc=face, ec=SOFT, lw=0.9)
    )
    for number, line in enumerate(text.split("\n")):
        centred = face != "none"
        axes.text(
            across[0] + (across[1] / 2 if centred else 0.1), top - 0.08 - _LINE_IN * (number + 0.5),
            line, ha="center" if centred else "left", va="center", color=INK,
            fontweight="bold" if centred and number == 0 else "normal",
        )  # fmt: skip


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    style = {"arrowstyle": "-|>", "color": SOFT, "lw": 0.9, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=end, xytext=start, arrowprops=style)
