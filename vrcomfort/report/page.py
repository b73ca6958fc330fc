"""The report as one self-contained HTML page."""

from __future__ import annotations

from typing import Any

from vrcomfort.report import words
from vrcomfort.report.descriptives import PRIMARY
from vrcomfort.web_page import inline_svg, page_templates

TEMPLATE = "report.html.j2"


def render_page(results: dict[str, Any], figures: dict[str, str]) -> str:
    """Fill the report template.

    Parameters
    ----------
    figures
        Name → SVG text, inlined into the page.
    """
    environment = page_templates()
    environment.filters |= {
        "number": words.number,
        "fraction": words.fraction,
        "p": words.p_value,
        "interval": words.interval,
        "degrees": words.degrees,
    }
    labels = results["labels"]
    return environment.get_template(TEMPLATE).render(
        r=results,
        labels=labels,
        names=words.titles_of(results),
        shorts=" and ".join(each["short"] for each in results["instruments"]),
        figures={
            name: inline_svg(svg, name, 'role="img" aria-hidden="true"')
            for name, svg in figures.items()
        },
        methods=words.methods(results),
        basis=words.basis_sentence(results["score_basis"]),
        described=_described(results),
        disagreements=_disagreements(results),
        fewest=words.fewest_for_shift(results["plan"]),
        headlines=[words.headline(t, results) for t in _most_wanted(results)],
    )


def _disagreements(results: dict[str, Any]) -> int:
    """Count the tests whose p and whose interval of r say different things of 0."""
    level = 1 - results["plan"]["confidence"]
    return sum(
        (test["p"] <= level) == (test["effect"]["low"] <= 0 <= test["effect"]["high"])
        for test in results["tests"]
        if not test["not_tested"] and test["effect"] and test["effect"]["low"] is not None
    )


MOST_HEADLINES = 8


def _most_wanted(results: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the tests to put in sentences: all, or those of the first score if they are many."""
    tests: list[dict[str, Any]] = results["tests"]
    if len(tests) <= MOST_HEADLINES:
        return tests
    return [test for test in tests if test["outcome"] == results["outcomes"][0]["name"]]


def _described(results: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of who is tested under each condition; differences if one pair is."""
    tests = results["tests"]
    rows = [row for row in results["descriptives"] if row["by"] == PRIMARY]
    if len({(test["a"], test["b"]) for test in tests}) == 1:
        rows += [
            {"outcome": test["outcome"], "condition": None, **test["descriptives"]["difference"]}
            for test in tests
            if not test["not_tested"]
        ]
    return sorted(rows, key=lambda row: results["plan"]["outcomes"].index(row["outcome"]))
