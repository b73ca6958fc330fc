"""`pack`: Parquet beside the CSV of long recordings. Needs neither a GPU nor a headset."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import MemoryOption, Quiet
from vrcomfort.cli.terminal import console, progress_bar, warn


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(pack)


def pack(
    study: Annotated[
        Path, typer.Argument(metavar="STUDY", help="A study folder, or one inside it.")
    ],
    memory: MemoryOption = "512MB",
    jobs: Annotated[int, typer.Option(help="Processes; each may take the memory.", min=1)] = 1,
    quiet: Quiet = False,
) -> None:
    """Write frames.parquet beside each frames.csv, and gaze.parquet beside each gaze.csv.

    Reports then read these, which is faster. The CSV files stay the record: a Parquet file whose
    CSV has changed is not read until `pack` is run again. A damaged recording is not packed.

    - `vrcomfort pack my_study`
    """
    from vrcomfort.recordings import pack_study
    from vrcomfort.records.recording import Memory
    from vrcomfort.workers import workers

    limit = Memory.of_text(memory)
    with progress_bar("packing", None, quiet=quiet), workers(jobs, None) as work:
        done = list(pack_study(study, limit, work))
    for each in done:
        if each.half_written:
            warn(f"{each.csv}: the last row is half-written and was left out")
    new = [each for each in done if each.new]
    before, after = _megabytes(e.csv for e in new), _megabytes(e.parquet for e in new)
    told = f"Packed: {len(new)} of {len(done)} recordings, {before:.1f} MB into {after:.1f} MB"
    console(quiet).print(f"{told}; {len(done) - len(new)} were packed before")


def _megabytes(files: Iterable[Path]) -> float:
    return sum(file.stat().st_size for file in files) / 1e6
