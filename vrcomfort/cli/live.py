"""A session in an OpenXR headset, or a rehearsal of one with a Monado runtime of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.cli.wiring import describe_machine, open_trace
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol

if TYPE_CHECKING:
    from vrcomfort.headset.openxr import OpenXrHeadset
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent import Respondent
    from vrcomfort.session.rehearsal import Rehearsal


@dataclass(frozen=True)
class LiveLab:
    """What a session in a headset needs.

    Parameters
    ----------
    panel
        A respondent who answers in the headset.
    """

    headset: OpenXrHeadset
    renderer: StereoRenderer
    panel: Respondent
    machine: Machine

    def headset_for(self, scene_name: str, scene: Any) -> OpenXrHeadset:
        """Lead the participant to the scene's starting point."""
        del scene_name
        self.headset.place(spawn=scene.spawn)
        return self.headset


@contextmanager
def live_lab(
    protocol: Protocol,
    *,
    size_px: tuple[int, int] | None = None,
    refresh_hz: float | None = None,
    monado_trace: Path | None = None,
    answers: Path | None = None,
) -> Iterator[LiveLab]:
    """Connect to the active OpenXR runtime; everything is released at the end.

    Parameters
    ----------
    monado_trace
        Start a Monado runtime, and let its head follow this trace: one sample per frame.
    answers
        What its controllers answer: whole numbers, in the order of the questions.

    Raises
    ------
    InputError
        If a part is missing; says what to do.
    """
    try:
        from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
    except ImportError as error:
        raise InputError(
            "the OpenXR bindings are not installed; pip install 'vrcomfort[openxr]'"
        ) from error
    from vrcomfort.render.gl import create_context
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent.panel import PanelRespondent
    from vrcomfort.session.panel_screen import PanelScreen

    with ExitStack() as owned:
        rehearsal = _rehearse(owned, monado_trace, answers)
        ctx = create_context()
        owned.callback(ctx.release)
        headset = owned.enter_context(
            OpenXrHeadset(
                ctx,
                OpenXrSettings(image_size_px=size_px, refresh_hz=refresh_hz),
                before_wait=rehearsal.before_frame if rehearsal else None,
            )
        )
        screen = PanelScreen(headset)
        if rehearsal is not None:
            rehearsal.screen = screen
        watch = rehearsal.watch if rehearsal else _nobody
        renderer = StereoRenderer(ctx, headset.image_size_px)
        owned.callback(renderer.release)
        machine = replace(
            describe_machine(renderer, protocol),
            runtime=headset.details["runtime"],
            timing_trust="none: nothing is displayed" if rehearsal else "runtime",
        )
        yield LiveLab(headset, renderer, PanelRespondent(screen, watch=watch), machine)


def _rehearse(owned: ExitStack, trace: Path | None, answers: Path | None) -> Rehearsal | None:
    if trace is None:
        if answers is not None:
            raise InputError("--monado-answers needs --monado-trace, the trace of the head")
        return None
    from vrcomfort.headset.monado import Monado
    from vrcomfort.session.rehearsal import Rehearsal

    head_trace = open_trace(trace) if trace else None
    assert head_trace is not None  # noqa: S101 - there is a path
    script = _read_answers(answers) if answers else []
    monado = owned.enter_context(Monado())
    feed = owned.enter_context(monado.feed())
    heads = map(head_trace.head.pose, cycle(range(len(head_trace))))
    return Rehearsal(feed, heads, iter(script))


def _read_answers(path: Path) -> list[int]:
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read the script of answers: {error}", file=path) from error
    numbers = []
    for line, words in enumerate(text.splitlines(), start=1):
        for word in words.partition("#")[0].split():
            if not word.isdigit():
                raise InputError(f"an answer is a whole number, not {word!r}", file=path, line=line)
            numbers.append(int(word))
    return numbers


def _nobody(page: object) -> None:
    """Watch over no page: a person answers."""
