"""`import` and `import-trace`: questionnaires and head traces of other labs and programs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.api.outputs import output_file
from vrcomfort.cli.options import Json, Quiet, output_path
from vrcomfort.cli.terminal import answer, console, warn
from vrcomfort.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("import")(import_answers)
    app.command("import-trace")(import_trace)


def import_answers(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILES", help="Files of answers: CSV, TSV, XLSX or JSON."),
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
        Path | None, typer.Option(help="Mapping of the columns (TOML), as --suggest writes it.")
    ] = None,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="Write a suggested mapping with its doubts.")
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
        bool,
        typer.Option(
            "--preview",
            help="Print what would be imported, and make no study; `--preview page.html` shows "
            "the files, coloured by role, and the mapping on a page.",
        ),
    ] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Import another lab's questionnaire answers (head traces: `import-trace`).

    - `vrcomfort import answers.csv --suggest --out map.toml`
    - `vrcomfort import answers.csv --suggest --preview page.html` to read it beside the file
    - Read `map.toml`, mend what is wrong in it, and answer its doubts.
    - `vrcomfort import answers.csv --mapping map.toml --out study`
    - `vrcomfort report study --out report`
    """
    if suggest == (mapping is not None):
        raise InputError("give either --suggest or --mapping MAP.toml; start with --suggest")
    page = next((file for file in files if preview and file.suffix == ".html"), None)
    files = [file for file in files if file != page]
    written = None if preview else out
    if as_json and (page or written) is None:
        raise InputError("--json says what was written; give --out, or --preview with a page")
    quiet = quiet or as_json
    if page is not None:
        _write_page(page, files, mapping, instrument or [], vocabulary or [], quiet)
    elif mapping is None:
        _suggest(files, written, instrument or [], vocabulary or [], quiet)
    elif out is None and not preview:
        raise InputError("--out is missing: the study folder to make (or give --preview)")
    else:
        _import(files, mapping, written, quiet)
    if as_json:
        answer({"written": str(page or written)})


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
    if found.guesses:
        warn(f"{found.guesses} more were not asked: the mapping has a guess for each ([[guesses]])")


def _write_page(
    page: Path,
    files: list[Path],
    mapping: Path | None,
    own: list[Path],
    vocabularies: list[Path],
    quiet: bool,
) -> None:
    """Write a page with the files and their mapping, given or suggested."""
    from vrcomfort.importing import import_files
    from vrcomfort.importing.mapping import parse_mapping, read_mapping
    from vrcomfort.importing.preview_page import is_preview, render_preview
    from vrcomfort.importing.suggest import suggest_mapping
    from vrcomfort.questionnaire import find_instrument

    if page.exists() and not is_preview(page):
        raise InputError("is no page of this command; choose another name for the page", file=page)
    if mapping is None:
        instruments = [find_instrument(file) for file in own]
        known = {str(file): each for file, each in zip(own, instruments, strict=True)}
        text = suggest_mapping(files, known, vocabularies).text
        read = parse_mapping(text, None)
    else:
        loaded = read_mapping(mapping)
        read, text, instruments = loaded.mapping, loaded.text, [*loaded.instruments]
    try:
        imported, refusal = import_files(files, read, instruments), ""
    except InputError as error:
        imported, refusal = None, str(error)
    html = render_preview(files, read, text, imported, instruments)
    output_file(page, files[0]).write_text(html, encoding="utf-8")
    console(quiet).print(f"Page: {page}")
    if refusal:
        warn(f"the import refuses this mapping: {refusal}")


def import_trace(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Head log of another program.")],
    out: Annotated[
        Path | None,
        typer.Option(
            parser=output_path,
            metavar="PATH",
            help="The trace to write (CSV); with --suggest, the mapping to write.",
        ),
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option(help="Mapping of the columns (TOML), as --suggest writes it.")
    ] = None,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="Write a suggested mapping with its doubts.")
    ] = False,
    format: Annotated[  # noqa: A002
        str | None, typer.Option(help="A format that needs no mapping: unity-euler.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Convert another program's head log to a trace.

    Logs are text with a row for each sample: time in any unit, the head's position, and its
    orientation as a quaternion or as Euler angles; in any left- or right-handed frame, with commas,
    semicolons, tabs or spaces, and decimal points or commas. What the columns mean is found out;
    what is not certain is asked in a mapping.

    - `vrcomfort import-trace log.csv --out trace.csv`
    - `vrcomfort import-trace log.csv --suggest --out map.toml`
    - `vrcomfort import-trace log.csv --mapping map.toml --out trace.csv`

    `--format unity-euler` is a log with the columns `Time x y z alpha beta gamma`: seconds, metres
    and Euler angles in degrees in Unity's left-handed frame (x right, y up, z forward), which turns
    about z first, then x, then y. The trace has OpenXR's right-handed frame (z backwards) and
    quaternions.
    """
    if sum((suggest, mapping is not None, format is not None)) > 1:
        raise InputError("give one of --suggest, --mapping and --format")
    if out is None and (as_json or not suggest):
        raise InputError("--out is missing: the trace to write, such as trace.csv")
    quiet = quiet or as_json
    if suggest:
        _suggest_log(file, out, quiet)
    elif out is not None:
        _import_log(file, out, mapping, format, quiet)
    if as_json:
        answer({"written": str(out)})


def _suggest_log(file: Path, out: Path | None, quiet: bool) -> None:
    """Write the mapping of a log, or print it, with the doubts on stderr."""
    from vrcomfort.importing.head_logs import described, suggest_log_mapping

    if out is not None and out.exists():
        raise InputError(
            "is there already, perhaps with your answers; choose another --out", file=out
        )
    found = suggest_log_mapping(file)
    if found.trace is not None and out is not None:
        for line in described(found.trace):
            console(quiet).print(line)
    if out is None:
        typer.echo(found.text, nl=False)
    else:
        output_file(out, file).write_text(found.text, encoding="utf-8")
        console(quiet).print(f"\nMapping: {out}")
    for number, doubt in enumerate(found.doubts, start=1):
        warn(f"doubt {number}: {doubt.words}")


def _import_log(
    file: Path,
    out: Path,
    mapping: Path | None,
    format: str | None,  # noqa: A002
    quiet: bool,
) -> None:
    from vrcomfort.importing.head_logs import (
        UNITY_EULER,
        described,
        import_log,
        load_log_mapping,
        suggest_log_mapping,
    )
    from vrcomfort.traces.trace import write_trace

    if format not in {None, "unity-euler"}:
        message = f"--format {format!r} is not known; the one there is: unity-euler"
        raise InputError(f"{message}. Without it, the columns are looked at")
    if mapping is not None:
        trace = import_log(file, load_log_mapping(mapping))
    elif format is not None:
        trace = import_log(file, UNITY_EULER)
    else:
        found = suggest_log_mapping(file)
        if found.trace is None or found.doubts:
            first, count = found.doubts[0].words, len(found.doubts)
            doubts = "a doubt" if count == 1 else f"{count} doubts"
            message = f"this log leaves {doubts}, the first: {first} Write a mapping with --suggest"
            raise InputError(
                f"{message} --out map.toml, answer them, and give --mapping", file=file
            )
        trace = found.trace
    for warning in trace.warnings:
        warn(warning)
    write_trace(trace, output_file(out, file))
    for line in described(trace):
        console(quiet).print(line)
    console(quiet).print(f"\nTrace: {out}")
