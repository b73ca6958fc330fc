"""Builds a report: reads, analyses, writes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.errors import spare
from vrcomfort.report.figures import (
    exposure_figure,
    paired_figure,
    subscale_figure,
    symptom_figure,
)
from vrcomfort.report.page import render_page
from vrcomfort.report.plan import instrument_of, load_plan
from vrcomfort.report.results import analyse, to_json
from vrcomfort.report.study_data import of_one_kind, protocol_of, read_study
from vrcomfort.report.tables import all_tables
from vrcomfort.report.words import headline
from vrcomfort.report.writing import file_name, write_report

if TYPE_CHECKING:
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.study_data import StudyData


@dataclass(frozen=True)
class ReportSummary:
    """What a report says in short, and where it is.

    Parameters
    ----------
    index, results
        ``index.html`` and ``results.json``.
    tables, figures
        The CSV and SVG files beside them.
    plan
        Name of the analysis plan.
    participants, analysed, withdrawn
        Numbers of people; `analysed` are in at least one test.
    headlines
        One sentence per test.
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
    headlines: tuple[str, ...]
    warnings: tuple[str, ...]


def build_report(
    source: Path,
    *,
    plan: Path | None = None,
    instrument: str | None = None,
    out: Path,
    simulated: bool | None = None,
) -> ReportSummary:
    """Write the report of a study.

    Parameters
    ----------
    source
        A study folder, any folder with ``questionnaires.csv`` files at any depth, or one file.
    plan
        An analysis plan; without one, the shipped plan of the study's protocol or the default.
    instrument
        Whose answers to report: the name of an instrument, or a file; see `read_study`. Without
        it, the plan's.
    simulated
        Of a study with both kinds of participants, analyse the simulated ones; `None`: real ones,
        where there are any.
    out
        Folder for ``index.html``, ``results.json``, ``tables/`` and ``figures/``; made if absent.
        Tables and figures of an earlier report that this one does not have are removed.

    Raises
    ------
    InputError
        If the study or the plan cannot be read, or `out` cannot be written, or that would
        overwrite what is read.
    """
    chosen = load_plan(plan, protocol=protocol_of(Path(source)))
    wanted = instrument or instrument_of(chosen, plan)
    study = _of_one_kind(read_study(Path(source), wanted), simulated)
    results, scored = analyse(study, chosen)
    figures = draw_figures(study, results, scored)
    files = {
        "index.html": render_page(results, figures),
        **{f"tables/{name}": text for name, text in all_tables(results, scored).items()},
        **{f"figures/{file_name(name)}.svg": text for name, text in figures.items()},
    }
    results["files"] = ["results.json", *files]
    spare([Path(source), plan], [Path(out) / name for name in results["files"]])
    write_report(Path(out), {"results.json": to_json(results), **files})
    return _summary(Path(out), results)


def _of_one_kind(study: StudyData, simulated: bool | None) -> StudyData:
    """Real and simulated participants are in no table together."""
    if simulated is None:
        simulated = all(each.get("respondent") == "simulated" for each in study.manifests)
        simulated = simulated and bool(study.manifests)
    return of_one_kind(study, simulated=simulated)


def draw_figures(study: StudyData, results: dict[str, Any], scored: Exposures) -> dict[str, str]:
    """Return name → SVG text of every figure that the data allow."""
    labels = {c["name"]: c["label"] for c in results["conditions"]}
    drawn: dict[str, str | None] = {}
    for test in results["tests"]:
        if test["outcome"] == results["plan"]["outcomes"][0]:
            name = f"paired_{test['outcome']}_{test['a']}_{test['b']}"
            drawn[name] = paired_figure(
                scored, test["a"], test["b"], labels=labels, outcome=test["outcome"]
            )
    drawn["subscales"] = subscale_figure(scored.table, results, results["weights"])
    drawn["symptoms"] = symptom_figure(results)
    drawn["exposures"] = exposure_figure(list(study.trials), results)
    return {name: svg for name, svg in drawn.items() if svg}


def _summary(out: Path, results: dict[str, Any]) -> ReportSummary:
    labels = {c["name"]: c["label"] for c in results["conditions"]}
    quality = results["quality"]
    excluded = [
        f"{row['place']}: {row['participant']}, {row['questionnaire']}: {row['reason']}"
        for row in quality["excluded_questionnaires"]
    ]
    return ReportSummary(
        index=out / "index.html",
        results=out / "results.json",
        tables=tuple(out / name for name in results["files"] if name.startswith("tables/")),
        figures=tuple(out / name for name in results["files"] if name.startswith("figures/")),
        plan=results["plan"]["name"],
        participants=results["participants"]["n"],
        analysed=len(results["participants"]["analysed"]),
        withdrawn=results["withdrawals"]["n"],
        headlines=tuple(
            headline(test, labels, results["outcome_names"]) for test in results["tests"]
        ),
        warnings=(
            *quality["reading"],
            *_changed(quality["protocol_versions"]),
            *excluded,
            *results["notices"],
        ),
    )


def _changed(versions: int) -> list[str]:
    if versions < 2:
        return []
    return [f"the protocol changed during the study: its sessions hold {versions} versions of it"]
