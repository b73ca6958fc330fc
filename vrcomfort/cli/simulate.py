"""`simulate` and `demo`: simulated participants of a protocol, and a whole example study."""

from __future__ import annotations

import shutil
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.api.outputs import output_folder
from vrcomfort.api.playback import open_trace
from vrcomfort.api.reports import write_report
from vrcomfort.api.simulation import finish, simulate_sessions
from vrcomfort.api.study_setup import outcome_sentence
from vrcomfort.api.views import render_views
from vrcomfort.cli.options import (
    DrawOption,
    ExposureOption,
    GroupReadable,
    Json,
    LanguageOption,
    ParticipantsOption,
    ProtocolArgument,
    Quiet,
    RefreshRate,
    Seed,
    Size,
    StudyFolder,
    StudySeed,
    TraceOption,
    TrustOption,
    output_option,
    parse_size,
)
from vrcomfort.cli.terminal import answer, ask_for_code, console, progress_bar, warn
from vrcomfort.errors import InputError
from vrcomfort.plurals import counted
from vrcomfort.protocol import load_protocol


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(simulate)
    app.command()(demo)


def simulate(
    protocol: ProtocolArgument,
    participants: ParticipantsOption,
    out: StudyFolder,
    seed: StudySeed = None,
    trace: TraceOption = None,
    size: Size = "320x400",
    refresh_hz: RefreshRate = None,
    exposure_s: ExposureOption = None,
    draw: DrawOption = True,
    language: LanguageOption = None,
    trust: TrustOption = None,
    group_readable: GroupReadable = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Run all sessions of simulated participants, with every frame rendered.

    With --no-draw nothing is drawn, and time jumps from one event to the next: answers, ratings
    and withdrawals as people give them, in no time.

    Where it was stopped, the same command goes on: what is recorded stays, and an interrupted
    session continues at its next exposure. One with other options is refused.

    - `vrcomfort simulate smoke --participants 4 --out my_study`
    - `vrcomfort simulate carnegie_2015 --participants 200 --no-draw --out answers`
    - `vrcomfort simulate carnegie_2015 -n 8 --exposure-s 4 --refresh-hz 4 --out my_study`
    """
    outcomes = simulate_sessions(
        load_protocol(protocol).spoken(language),
        participants=participants,
        out=out,
        seed=seed,
        size_px=parse_size(size),
        trace=open_trace(trace, note=warn) if trace else None,
        refresh_hz=refresh_hz,
        exposure_s=exposure_s,
        group_readable=group_readable,
        frames=draw,
        trust=trust,
        ask=ask_for_code,
        note=warn,
        progress=partial(progress_bar, quiet=quiet or as_json),
    )
    if as_json:
        answer({"study": str(out), "sessions": [asdict(each) for each in outcomes]})
    for outcome in () if as_json else outcomes:
        console(quiet).print(outcome_sentence(outcome, out))
    if outcomes[-1].status == "aborted":
        warn("the same command goes on where this was stopped")
    finish(outcomes)


DEMO_PROTOCOL = "carnegie_2015"
DEMO_SIZE_PX = (320, 400)
DEMO_PICTURE_SIZE_PX = (640, 800)
DEMO_PICTURE_POSES = {
    "temple": (-1, 1.6, -4.3, 47, -4, 0),
    "mountain": (1.2, 1.5, -1.9, -32, -8, 0),
}
"""Close to something detailed, with the room or the range behind it."""
DEMO_REFRESH_HZ = 4.0
DEMO_EXPOSURE_S = 4.0
"""16 frames an exposure that span 4 s of walking: about 500 stereo frames for 8 participants."""


def demo(
    out: Annotated[Path, output_option(help="Folder; an earlier demo in it is replaced.")] = Path(
        "vrcomfort-demo"
    ),
    participants: Annotated[
        int, typer.Option("--participants", "-n", help="Number of participants.", min=2, max=200)
    ] = 8,
    seed: Seed = 1,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate Carnegie & Rhee's study with shortened exposures, render it, and report.

    The participants are simulated: the numbers show what a report looks like, and nothing else.

    - `vrcomfort demo`
    - `vrcomfort demo --out somewhere --participants 20`
    """
    study, pictures = _fresh(out)
    quiet = quiet or as_json
    say = console(quiet).print
    say(f"Simulating {counted(participants, 'participants')}, two sessions each ...")
    outcomes = simulate_sessions(
        load_protocol(DEMO_PROTOCOL),
        participants=participants,
        out=study,
        seed=seed,
        size_px=DEMO_SIZE_PX,
        refresh_hz=DEMO_REFRESH_HZ,
        exposure_s=DEMO_EXPOSURE_S,
        note=warn,
        progress=partial(progress_bar, quiet=quiet),
    )
    if outcomes[-1].status == "aborted":
        raise KeyboardInterrupt  # as the session has heard it, which then closed its files
    withdrawn = sum(outcome.status == "withdrawn" for outcome in outcomes)
    say(f"{withdrawn} of {participants} withdrew. Rendering pictures ...")
    files = _pictures(pictures, quiet)
    say("Writing the report ...")
    with progress_bar("report", None, quiet=quiet):
        report = write_report(study, out / "report", plan=DEMO_PROTOCOL, note=warn).index
    if as_json:
        answer({"study": str(study), "pictures": [*map(str, files)], "report": str(report)})
        return
    console().print(f"\nStudy:    {study}")
    for file in files:
        console().print(f"Picture:  {file}")
    console().print(f"Report:   {report}")


def _fresh(out: Path) -> tuple[Path, Path]:
    """Return new study and picture folders; only those of an earlier demo are removed."""
    parts = [out / name for name in ("study", "pictures", "report")]
    foreign = [path for path in out.glob("*") if path not in parts] if out.is_dir() else []
    if foreign:
        message = f"holds {foreign[0].name}, which no demo made; choose another --out"
        raise InputError(message, file=out)
    output_folder(out)
    for part in parts:
        shutil.rmtree(part, ignore_errors=True)
    return parts[0], parts[1]


def _pictures(folder: Path, quiet: bool) -> list[Path]:
    """Draw each scene under each condition at a place where the difference shows."""
    study = load_protocol(DEMO_PROTOCOL)
    return [
        render_views(
            scene,
            condition,
            pose=DEMO_PICTURE_POSES[scene],
            size_px=DEMO_PICTURE_SIZE_PX,
            ipd_m=study.headset.ipd_m,
            note=warn,
            progress=partial(progress_bar, quiet=quiet),
        ).write(folder / f"{scene}_{condition.name}")
        for scene in study.scenes
        for condition in study.conditions
    ]
