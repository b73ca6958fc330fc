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
from vrcomfort.report.pairs import Side
from vrcomfort.report.plan import Plan, find_plan, load_plan, plan_of, shipped_plans
from vrcomfort.report.results import PLAN_FILE, analyse, to_json
from vrcomfort.report.study_data import of_one_kind, read_study
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
    plan: str | Path | None = None,
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
        An analysis plan, or the name of a shipped one; without one, the shipped plan of the
        study's protocol, or one that is derived from the data. It is written beside the report.
    instrument
        The name or the file of the only instrument to report; all that were asked without it.
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
    study = _of_one_kind(read_study(Path(source), instrument), simulated)
    chosen = choose_plan(study, plan)
    results, scored = analyse(study, chosen)
    figures = draw_figures(study, results, scored)
    files = {
        PLAN_FILE: chosen.text,
        "index.html": render_page(results, figures),
        **{f"tables/{name}": text for name, text in all_tables(results, scored).items()},
        **{f"figures/{file_name(name)}.svg": text for name, text in figures.items()},
    }
    results["files"] = ["results.json", *files]
    spare(_read(source, plan, out), [Path(out) / name for name in results["files"]])
    write_report(Path(out), {"results.json": to_json(results), **files})
    return _summary(Path(out), results)


def choose_plan(study: StudyData, plan: str | Path | None) -> Plan:
    """Return the plan asked for; else the shipped one of the study's protocol; else a derived one.

    Raises
    ------
    InputError
        If the plan cannot be found or is wrong, with line and column.
    """
    if plan is not None:
        return load_plan(find_plan(plan), study.instruments.values())
    shipped = {each.name: each.file for each in shipped_plans()}
    file = shipped.get(study.protocol or "")
    return load_plan(file, study.instruments.values()) if file else plan_of(study)


def _read(source: Path, plan: str | Path | None, out: Path) -> list[Path]:
    """Return what is read and must stay; a report's own plan.toml is written again as it was."""
    own = Path(out) / PLAN_FILE
    file = None if plan is None else find_plan(plan)
    again = file is None or (own.exists() and file.samefile(own))
    return [Path(source), *([] if again or file is None else [file])]


def _of_one_kind(study: StudyData, simulated: bool | None) -> StudyData:
    """Real and simulated participants are in no table together."""
    if simulated is None:
        simulated = all(each.get("respondent") == "simulated" for each in study.manifests)
        simulated = simulated and bool(study.manifests)
    return of_one_kind(study, simulated=simulated)


def draw_figures(study: StudyData, results: dict[str, Any], scored: Exposures) -> dict[str, str]:
    """Return name → SVG text of every figure that the data allow."""
    labels, wanted = results["labels"], results["plan"]["figures"]
    drawn: dict[str, str | None] = {}
    for test in results["tests"]:
        if test["outcome"] == results["outcomes"][0]["name"]:
            name = f"paired_{test['outcome']}_{test['a']}_{test['b']}"
            drawn[name] = paired_figure(
                scored,
                *(Side(**side) for side in test["sides"]),
                labels=labels,
                outcome=test["outcome"],
                complete=results["plan"]["withdrawals"] != "available_pairs",
            )
    drawn["subscales"] = subscale_figure(scored.table, results, results["weights"])
    drawn["symptoms"] = symptom_figure(results)
    drawn["exposures"] = exposure_figure(list(study.trials), results)
    return {
        name: svg
        for name, svg in drawn.items()
        if svg and (not wanted or name.partition("_")[0] in wanted)
    }


def _summary(out: Path, results: dict[str, Any]) -> ReportSummary:
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
        headlines=tuple(headline(test, results) for test in results["tests"]),
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
