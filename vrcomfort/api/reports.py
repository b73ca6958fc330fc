"""Reports of studies, and of files that are imported for them."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.api.outputs import Note, as_warning, output_folder
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from vrcomfort.records.choice import Choice
    from vrcomfort.records.reader import Study
    from vrcomfort.report import Form, ReportSummary
    from vrcomfort.report.plan import Plan

IMPORTED = "imported"
"""The folder inside the report that holds what was read of such a file, and how."""


def read_study(folder: str | Path) -> Study:
    """Open a study for analysis: pandas frames and DuckDB relations, read when they are asked for.

    Parameters
    ----------
    folder : str or Path
        A study folder, any folder with tables of its names, or one ``questionnaires.csv``.

    Returns
    -------
    Study
        ``participants``, ``trials``, ``answers``, ``ratings`` and ``events`` are tidy data frames;
        ``scores("ssq")`` has a row for each questionnaire that was asked; ``frames`` and ``gaze``
        are DuckDB relations (``study.frames.filter("trial = 2").df()``).

    Raises
    ------
    InputError
        If there is no such folder or file; reading raises it for a damaged table, with its place.

    Examples
    --------
    >>> import vrcomfort
    >>> study = vrcomfort.read_study("pilot")  # doctest: +SKIP
    >>> study.scores("ssq").groupby("condition")["total"].mean()  # doctest: +SKIP
    """
    from vrcomfort.records.reader import Study

    return Study(folder)


def load_plan(name_or_file: str | Path) -> Plan:
    """Read an analysis plan.

    Parameters
    ----------
    name_or_file : str or Path
        The name of a shipped plan, such as ``"carnegie_2015"``, or a TOML file.

    Returns
    -------
    Plan
        The validated plan; `write_report` takes it.

    Raises
    ------
    InputError
        If there is none, or it is wrong, with line and column.

    Examples
    --------
    >>> import vrcomfort
    >>> vrcomfort.load_plan("carnegie_2015").outcomes
    ('T', 'N', 'O', 'D')
    """
    from vrcomfort.report.plan_files import find_plan
    from vrcomfort.report.plan_files import load_plan as load

    return load(find_plan(name_or_file))


def write_report(
    study: Study | str | Path | None,
    out: str | Path,
    *,
    plan: Plan | str | Path | None = None,
    instrument: str | None = None,
    simulated: bool | None = None,
    forms: Sequence[Form] = ("svg", "png", "pdf"),
    memory: str = "512MB",
    cluster: str | None = None,
    without: Sequence[str] = (),
    accept_flagged: bool = False,
    replace: bool = False,
    note: Note = as_warning,
) -> ReportSummary:
    """Analyse a study and write its report, as `vrcomfort report` does.

    Parameters
    ----------
    study : Study, str, Path or None
        A study, its folder, any folder with ``questionnaires.csv`` files, or one file of answers:
        tidy, or of a layout that is recognised without doubt. None: the files that `plan` names.
    out : str or Path
        Folder for ``index.html``, ``results.json``, ``tables/`` and ``figures/``; made if absent.
    plan : Plan, str or Path, optional
        An analysis plan as `load_plan` gives it, its file, or the name of a shipped one; without
        it, the protocol's own, or one that is derived from the data.
    instrument : str, optional
        Name or file of the only questionnaire to report; all that were asked without it.
    simulated : bool, optional
        Of a study with both, the simulated participants; None: the real ones, where there are any.
    forms : sequence of {"svg", "png", "pdf"}
        Forms in which figures are written; none: no figures.
    memory : str
        The most memory that reading frames may take.
    cluster : str, optional
        Address of a running Dask scheduler.
    without : sequence of str
        Sessions that are left out, such as ``"P07/ses-2"``; the report says so.
    accept_flagged : bool
        Verify the study, and say in the report what is wrong with it.
    replace : bool
        Write over the report of another study, too, if `out` holds one.
    note : callable
        Takes sentences on the data; Python warnings without it.

    Returns
    -------
    ReportSummary
        Paths of what was written, the number of participants, and a sentence for each test.

    Raises
    ------
    InputError
        If the study or the plan cannot be used, `out` cannot be written, or holds the report of
        another study.

    Examples
    --------
    >>> import vrcomfort
    >>> summary = vrcomfort.write_report("pilot", "report", forms=())  # doctest: +SKIP
    >>> summary.index  # doctest: +SKIP
    """
    from vrcomfort.records.reader import Study
    from vrcomfort.records.recording import Memory
    from vrcomfort.report import build_report
    from vrcomfort.report.writing import name_of_study, refuse_another_study

    folder = output_folder(Path(out))
    given = study.folder if isinstance(study, Study) else study
    given = _plan_with_files(plan) if given is None else Path(given)
    name = name_of_study(given)
    if not replace:
        refuse_another_study(folder, name)
    most = Memory.of_text(memory)
    choice, notes = _chosen(given, without, accept_flagged=accept_flagged)
    with _without_import_if_refused(folder):
        source = (
            _study_of(given, folder, note)
            if study is not None
            else _study_of_plan(given, folder, note)
        )
        summary = build_report(
            source,
            name=name,
            plan=plan,
            instrument=instrument,
            out=folder,
            simulated=simulated,
            forms=forms,
            memory=most,
            cluster=cluster,
            without=choice.without,
            notes=notes,
        )
    if study is not None and source != given:
        note(f"{given}: understood without a mapping; how, {source / 'mapping.toml'} says")
    for sentence in (summary.without_primary, *summary.warnings):
        if sentence:
            note(sentence)
    return summary


@contextmanager
def _without_import_if_refused(out: Path) -> Iterator[None]:
    """Remove the import that a report was to be made of, and folders made for it, if it is not."""
    made = [each for each in (out / IMPORTED, out, *out.absolute().parents) if not each.exists()]
    try:
        yield
    except InputError:
        if out / IMPORTED in made:
            shutil.rmtree(out / IMPORTED, ignore_errors=True)
        for folder in made:
            with suppress(OSError):  # not made, or with something in it
                folder.rmdir()
        raise


def _chosen(
    source: Path, without: Sequence[str], *, accept_flagged: bool
) -> tuple[Choice, list[str]]:
    """Return the sessions that a report takes, and the sentences on its choice.

    Raises
    ------
    InputError
        If a session that is to be left out is not there.
    """
    from vrcomfort.exchange.verifying import verify_study
    from vrcomfort.records.choice import Choice

    choice = Choice.of_texts(without, accept_flagged=accept_flagged)
    choice.require_there(source)
    faults = verify_study(source, without=choice.without).faults if accept_flagged else []
    return choice, choice.sentences([str(each) for each in faults])


def _study_of(source: Path, out: Path, note: Note) -> Path:
    """Return the source of a report: a folder or tidy file as it is, else its import.

    Parameters
    ----------
    out
        The report's folder, in which the import is kept.

    Raises
    ------
    InputError
        If a mapping is needed, with the command that writes one.
    """
    if not source.is_file() or _is_tidy(source):
        return source
    from vrcomfort.importing import MappingFile, parse_mapping, write_study
    from vrcomfort.importing.suggest import suggest_mapping

    found = suggest_mapping([source])
    if found.doubts or found.imported is None:
        raise InputError(_needs_mapping(source, found.doubts), file=source)
    mapping = parse_mapping(found.text, None)
    file = MappingFile(mapping, Path("suggested.toml"), found.text)
    folder = out / IMPORTED
    write_study(folder, found.imported, file, [source])
    for sentence in (*found.notes, *found.imported.notes):
        note(sentence)
    return folder


def _plan_with_files(plan: Plan | str | Path | None) -> Path:
    """Return the file of a plan that is to name the data, as no study is given.

    Raises
    ------
    InputError
        If there is no plan.
    """
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.plan_files import find_plan

    file = plan.file if isinstance(plan, Plan) else plan
    if file is None:
        raise InputError("give a study, or a plan that names files in [data]")
    return find_plan(file)


def _study_of_plan(file: Path, out: Path, note: Note) -> Path:
    """Return the import of the files that a plan names, kept in the report's folder.

    Raises
    ------
    InputError
        If it names no files, or they are not as their mapping says.
    """
    from vrcomfort.report.plan import data_files

    named = data_files(file)
    if named is None:
        message = "this plan names no files; give the study, or add [data] with files and mapping"
        raise InputError(message, file=file)
    from vrcomfort.importing import import_files, load_mapping, write_study

    files, mapping = named
    loaded = load_mapping(mapping)
    imported = import_files(files, loaded.mapping, loaded.instruments)
    for sentence in imported.notes:
        note(sentence)
    write_study(out / IMPORTED, imported, loaded, files)
    return out / IMPORTED


def _is_tidy(file: Path) -> bool:
    """Return whether a file has the columns of ``questionnaires.csv``, or some of them."""
    try:
        first = next(CsvTable.parts(file, appended=True, most_rows=1))
        header = {name.lower() for name in first.header}
    except InputError:
        return False
    return not header or bool({"item", "response"} & header)


def _needs_mapping(source: Path, doubts: tuple[str, ...]) -> str:
    words = f"vrcomfort import {shlex.quote(str(source))} --suggest --out map.toml"
    if not doubts:
        return f"no questionnaire was found in this file; to say what is in it: {words}"
    others = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
    return f"this file needs a mapping, for this is doubtful: {doubts[0]}{others} Write it: {words}"
