"""`import` and `import-trace`: questionnaires and head traces of other labs and programs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.api.outputs import output_file
from vrcomfort.cli.options import Quiet, output_option, output_path
from vrcomfort.cli.terminal import console, warn
from vrcomfort.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("import")(import_answers)
    app.command("import-trace")(import_trace)


def import_answers(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILES", help="CSV, TSV, XLSX or JSON; one or more.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            parser=output_path,
            metavar="PATH",
            help="The study folder to make; with --suggest, the mapping to write.",
        ),
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option(help="What the columns mean (TOML), as --suggest writes it.")
    ] = None,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="Write a mapping from the files, with its doubts.")
    ] = False,
    instrument: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE.toml", help="With --suggest: an instrument of your own."),
    ] = None,
    vocabulary: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE.toml", help="With --suggest: labels and words of your own."),
    ] = None,
    preview: Annotated[
        bool, typer.Option("--preview", help="Print what would be imported; write nothing.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Import questionnaire answers of another lab (for head traces there is `import-trace`).

    - `vrcomfort import answers.csv --suggest --out map.toml`
    - Read `map.toml`, mend what is wrong in it, and answer its doubts.
    - `vrcomfort import answers.csv --mapping map.toml --out study`
    - `vrcomfort report study --out report`
    """
    if suggest == (mapping is not None):
        raise InputError("give either --suggest or --mapping MAP.toml; start with --suggest")
    if mapping is None:
        _suggest(files, None if preview else out, instrument or [], vocabulary or [], quiet)
    elif out is None and not preview:
        raise InputError("--out is missing: the study folder to make (or give --preview)")
    else:
        _import(files, mapping, None if preview else out, quiet)


def _import(files: list[Path], mapping: Path, out: Path | None, quiet: bool) -> None:
    from vrcomfort.importing import import_files, load_mapping, preview, write_study

    loaded = load_mapping(mapping)
    imported = import_files(files, loaded.mapping, loaded.instruments)
    for note in imported.notes:
        warn(note)
    for line in preview(imported):
        console(quiet).print(line)
    if out is not None:
        write_study(out, imported, loaded, files)
        console(quiet).print(f"\nStudy: {out}")


def _suggest(
    files: list[Path], out: Path | None, own: list[Path], vocabularies: list[Path], quiet: bool
) -> None:
    """Write a mapping, or print it, with notes on stderr."""
    from vrcomfort.importing import preview
    from vrcomfort.importing.suggest import suggest_mapping
    from vrcomfort.questionnaire import find_instrument

    beside = out.parent if out is not None else Path()
    known = {os.path.relpath(file, beside): find_instrument(file) for file in own}
    found = suggest_mapping(files, known, vocabularies)
    for note in found.notes:
        warn(note)
    if found.imported is not None and (out is not None or not quiet):
        for line in preview(found.imported):
            console(quiet or out is None).print(line)
    if out is None:
        typer.echo(found.text, nl=False)
    else:
        if out.exists():
            message = "is there already, perhaps with your answers; choose another --out"
            raise InputError(message, file=out)
        output_file(out, files[0]).write_text(found.text, encoding="utf-8")
        console(quiet).print(f"\nMapping: {out}")
    for number, doubt in enumerate(found.doubts, start=1):
        warn(f"doubt {number}: {doubt}")


def import_trace(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A log that another program wrote.")],
    out: Annotated[Path, output_option(help="The trace to write (CSV).")],
    format: Annotated[str, typer.Option(help="What wrote it: unity-euler.")] = "unity-euler",  # noqa: A002
    quiet: Quiet = False,
) -> None:
    """Turn another program's head log into a trace.

    `unity-euler` is text: a first line `Time x y z alpha beta gamma`, then one row for each sample,
    with commas between its seven numbers and points as decimals, such as `0.5,0,1.6,0,10,90,0`.

    - Time in seconds, each later than the one before.
    - x, y, z: the head's position in metres, in Unity's left-handed frame (x right, y up,
      z forward).
    - alpha, beta, gamma: Unity's Euler angles in degrees about x (positive looks down), y (positive
      turns right) and z (positive tips to the left), as eulerAngles gives them: it turns about z
      first, then x, then y.

    The trace has OpenXR's right-handed frame (z backwards) and quaternions.

    - `vrcomfort import-trace log.txt --format unity-euler --out trace.csv`
    """
    from vrcomfort.traces.trace import import_trace as read
    from vrcomfort.traces.trace import write_trace

    if format != "unity-euler":
        raise InputError(f"--format {format!r} is not known; the one there is: unity-euler")
    trace = read(file, format="unity-euler")
    for warning in trace.warnings:
        warn(warning)
    write_trace(trace, output_file(out, file))
    console(quiet).print(f"{len(trace)} samples over {trace.duration_s:.1f} s: {out}")
