"""Builds a report: reads, analyses, writes."""

from __future__ import annotations

import gc
import os
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from vrcomfort.csv_table import whole_or_none
from vrcomfort.errors import InputError, spare
from vrcomfort.report.analyses import ReportContext, outcome_sentences, sentences
from vrcomfort.report.derived_plan import plan_of
from vrcomfort.report.figures import draw_figures, figure_tables
from vrcomfort.report.page import render_page
from vrcomfort.report.paper import FILE as PAPER_FILE
from vrcomfort.report.plan import Plan
from vrcomfort.report.plan_files import find_plan, load_plan, read_plan, shipped_files
from vrcomfort.report.reproduce import r_script
from vrcomfort.report.residuals import residuals_of
from vrcomfort.report.results import PLAN_FILE, analyse, results_json
from vrcomfort.report.sections import run_sections, section_sentences
from vrcomfort.report.study_data import SIMULATED, of_one_kind, read_study, with_frames
from vrcomfort.report.tables import all_tables
from vrcomfort.report.writing import file_name, name_of_study, write_report

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from vrcomfort.records.choice import SessionName
    from vrcomfort.records.recording import Memory
    from vrcomfort.report.analyses import Sentence
    from vrcomfort.report.canvas import Drawing
    from vrcomfort.report.results import Results
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.study_data import StudyData


Form = Literal["svg", "png", "pdf"]
FORMS: tuple[Form, ...] = ("svg", "png", "pdf")


@dataclass(frozen=True)
class ReportSummary:
    """Summary of a report, and the paths of its files.

    Parameters
    ----------
    index, results
        ``index.html`` and ``results.json``.
    tables, figures
        The CSV files beside them; the figures as SVG, PNG and PDF.
    plan
        Name of the analysis plan.
    participants, analysed, withdrawn
        Numbers of people; `analysed` are in at least one test.
    without_primary
        That the planned primary outcome is not in the data, why, and what to do; else blank.
    headlines
        One sentence per test; of secondary outcomes alone where the primary one is missing.
    warnings
        What was left out while reading or scoring, and last what to know before any number: one
        sentence each.
    """

    index: Path
    results: Path
    tables: tuple[Path, ...]
    figures: tuple[Path, ...]
    plan: str
    participants: int
    analysed: int
    withdrawn: int
    without_primary: str
    headlines: tuple[str, ...]
    warnings: tuple[str, ...]


def build_report(
    source: Path,
    *,
    name: str | None = None,
    plan: Plan | str | Path | None = None,
    instrument: str | None = None,
    out: Path,
    simulated: bool | None = None,
    forms: Collection[Form] = FORMS,
    memory: Memory | None = None,
    cluster: str | None = None,
    without: Collection[SessionName] = (),
    notes: Collection[str] = (),
) -> ReportSummary:
    """Write the report of a study.

    Parameters
    ----------
    source
        A study folder, any folder with ``questionnaires.csv`` files at any depth, or one file.
    name
        Of the source in results.json; without it, that of its folder or file.
    plan
        An analysis plan, its file, or the name of a shipped one; without one, the shipped plan of
        the study's protocol, or one that is derived from the data. Its text is written beside the
        report.
    instrument
        The name or the file of the only instrument to report; all that were asked without it.
    simulated
        Of a study with both kinds of participants, analyse the simulated ones; `None`: real ones,
        where there are any.
    out
        Folder for ``index.html``, ``results.json``, ``reproduce.R``, ``tables/`` and ``figures/``;
        made if absent.
        Tables and figures of an earlier report that this one does not have are removed.
    forms
        In which figures are written; none: no figure is drawn, and the page has none. They take
        most of the time of a small report.
    memory
        The most that reading frames may take; 512 MB without it.
    cluster
        Address of a running Dask scheduler, whose workers read the frames.
    without
        Sessions that are left out.
    notes
        Sentences that the report has among those on what was read.

    Raises
    ------
    InputError
        If the study or the plan cannot be read, or `out` cannot be written, or that would
        overwrite what is read.
    """
    with _uncollected():
        study = _of_one_kind(read_study(Path(source), instrument, without), simulated)
    study = replace(study, warnings=(*notes, *study.warnings))
    study = with_frames(study, memory=memory, cluster=cluster)
    with _uncollected():
        return _build(study, Path(source), name, plan, Path(out), forms, memory)


def _build(
    study: StudyData,
    source: Path,
    name: str | None,
    plan: Plan | str | Path | None,
    out: Path,
    forms: Collection[Form],
    memory: Memory | None,
) -> ReportSummary:
    """Analyse a study, and write all files of the report; see `build_report`."""
    chosen = choose_plan(study, plan)
    results, scored = analyse(study, chosen)
    sections = run_sections(results.for_sections(study, memory))
    called = replace(results.study, source=name or name_of_study(source))
    results = replace(results.with_sections(sections), study=called, date=_today())
    words = results.vocabulary
    several = max(results.participants.exposures_per_condition.values(), default=0) > 1
    context = ReportContext(words, chosen, several=several, drawn=bool(forms))
    figures: dict[str, Drawing] = {}
    drawn_from: dict[str, list[Cells]] = {}
    if forms:
        left = [
            residuals_of(scored, chosen, results.tests, outcome.name)
            for outcome in results.outcomes
        ]
        figures = draw_figures(study, results, scored, left, sections, context)
        drawn_from = figure_tables(study, results, scored, left)
    tables = all_tables(results, scored, sections, drawn_from)
    written = [form for form in FORMS if form in forms]
    pages = render_page(results, figures, context, written, sections, tables)
    files: dict[str, str | bytes] = {
        PLAN_FILE: chosen.text,
        "index.html": pages.page,
        PAPER_FILE: pages.paper,
        "reproduce.R": r_script(),
        **{f"tables/{name}": text for name, text in tables.items()},
        **_figure_files(figures, forms),
    }
    results = replace(results, files=("results.json", *files))
    spare(_read(source, plan, out), [out / name for name in results.files])
    write_report(out, {"results.json": results_json(results), **files})
    return _summary(out, results, section_sentences(sections, words))


@contextmanager
def _uncollected() -> Iterator[None]:
    """Keep Python from looking for garbage: nearly all that reading makes is kept to the end."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _today() -> str:
    """Return the day of the report; SOURCE_DATE_EPOCH makes it another, for equal bytes."""
    epoch = whole_or_none(os.environ.get("SOURCE_DATE_EPOCH"))
    moment = datetime.now(UTC) if epoch is None else datetime.fromtimestamp(epoch, UTC)
    return moment.date().isoformat()


def _figure_files(figures: dict[str, Drawing], forms: Collection[Form]) -> dict[str, str | bytes]:
    """Return the path of each figure in each of the forms wanted."""
    files: dict[str, str | bytes] = {}
    for name, drawing in figures.items():
        path = f"figures/{file_name(name)}"
        if "svg" in forms:
            files[f"{path}.svg"] = drawing.svg
        if "png" in forms:
            files[f"{path}.png"] = drawing.png()
        if "pdf" in forms:
            files[f"{path}.pdf"] = drawing.pdf()
    return files


def choose_plan(study: StudyData, plan: Plan | str | Path | None) -> Plan:
    """Return the plan asked for; else the shipped one of the study's protocol; else a derived one.

    Raises
    ------
    InputError
        If the plan cannot be found or is wrong, with line and column, or has other settings than
        its text, by which the report would be known.
    """
    instruments = study.instruments.values()
    if isinstance(plan, Plan):
        read = read_plan(plan.text, plan.file, instruments) if plan.text else None
        if plan != read:
            message = "this plan has settings that are not in its text, which a report keeps"
            raise InputError(f"{message}; write them to a file, and load that", file=plan.file)
        return plan
    if plan is not None:
        return load_plan(find_plan(plan), instruments)
    file = shipped_files().get(study.protocol or "")
    return load_plan(file, instruments) if file else plan_of(study)


def _read(source: Path, plan: Plan | str | Path | None, out: Path) -> list[Path]:
    """Return input files that the report must not overwrite, less its own plan.toml."""
    own = Path(out) / PLAN_FILE
    given = plan.file if isinstance(plan, Plan) else plan
    file = None if given is None else find_plan(given)
    again = file is None or (own.exists() and file.exists() and file.samefile(own))
    return [Path(source), *([] if again or file is None else [file])]


def _of_one_kind(study: StudyData, simulated: bool | None) -> StudyData:
    """Real and simulated participants are in no table together."""
    if simulated is None:
        simulated = all(each.respondent == SIMULATED for each in study.manifests)
        simulated = simulated and bool(study.manifests)
    return of_one_kind(study, simulated=simulated)


def _summary(out: Path, results: Results, of_sections: Sequence[Sentence]) -> ReportSummary:
    quality = results.quality
    excluded = [
        f"{row.place}: {row.participant}, {row.questionnaire}: {row.reason}"
        for row in quality.excluded_questionnaires
    ]
    return ReportSummary(
        index=out / "index.html",
        results=out / "results.json",
        tables=tuple(out / name for name in results.files if name.startswith("tables/")),
        figures=tuple(out / name for name in results.files if name.startswith("figures/")),
        plan=results.plan.name,
        participants=results.participants.n,
        analysed=len(results.participants.analysed),
        withdrawn=results.withdrawals.n,
        without_primary=results.without_primary or "",
        headlines=(*_headlines(results), *(each.text for each in of_sections)),
        warnings=(
            *quality.reading,
            *_changed(quality.protocol_versions),
            *excluded,
            *results.notices,
        ),
    )


def _headlines(results: Results) -> Iterator[str]:
    """Yield the answers, called secondary where the planned primary outcome is not in the data."""
    words = results.vocabulary
    called = "Secondary: " if results.without_primary else ""
    answered = [sentence for _, sentence in outcome_sentences(results.rows, words)]
    for line in (*answered, *sentences(results.rows, words)):
        yield f"{called}{line.text}"


def _changed(versions: int) -> list[str]:
    if versions < 2:
        return []
    return [f"the protocol changed during the study: its sessions hold {versions} versions of it"]
