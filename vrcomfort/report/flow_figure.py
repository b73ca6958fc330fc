"""The participant flow chart: enrolled, exposed, completed, analysed, and who left on the way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib.patches import Rectangle

from vrcomfort.report import palette
from vrcomfort.report.canvas import INK, SOFT, Drawing, canvas, lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH_IN, _LINE_IN, _GAP_IN = 6.2, 0.19, 0.16
_MAIN, _SIDE = (0.0, 2.0), (2.7, 3.5)
"""Left edge and width of the boxes of stages and of reasons, in inches."""


def flow_figure(flow: list[dict[str, Any]]) -> Drawing:
    """Draw the stages below each other; beside the way to the next one, who left and why."""
    parts: list[tuple[str, str]] = []
    for stage in flow:
        parts.append(("stage", _stage(stage)))
        if stage["left"]:
            parts.append(("reasons", _reasons(stage["left"])))
    heights = [_height(text) for _, text in parts]
    total = sum(heights) + _GAP_IN * (len(parts) + 1)
    with canvas("flow", _WIDTH_IN, total) as (figure, drawing):
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


def _stage(stage: dict[str, Any]) -> str:
    text = f"{stage['stage']}\nn = {stage['n']}"
    if stage.get("again"):
        text += f"\n{stage['again']} of them withdrew"
    if stage.get("in_every_test", stage["n"]) != stage["n"]:
        text += f"\n{stage['in_every_test']} in every test"
    return text


def _reasons(rows: list[dict[str, Any]]) -> str:
    return "\n".join(lines(f"{row['n']}: {row['reason']}", 46) for row in rows)


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
