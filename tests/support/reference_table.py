"""Reference numbers of docs/statistics_checks.md: `python -m tests.support.reference_table`.

One row per test and convention: of all data sets it shows the one in which ours is farthest from
what is expected. Every single number is tested in `tests/stats/test_oracles.py` or
`tests/stats/test_reference_table.py`.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from tests.support import oracles, published
from tests.support.places import ROOT

PAGE = ROOT / "docs" / "statistics_checks.md"
BEGIN, END = "<!-- reference table: begin -->", "<!-- reference table: end -->"
COMMAND = "python -m tests.support.reference_table"

TESTS = {
    "signed_rank": "signed rank",
    "shift": "Hodges–Lehmann, order statistics",
    "rank_biserial": "rank-biserial, Fisher z",
    "worst_rank": "worst rank of withdrawals",
    "crossover": "crossover",
    "anova": "ANOVA, type III",
    "anova_type_ii": "ANOVA, type II",
    "two_groupings": "ANOVA, two groupings",
    "friedman": "Friedman",
    "mixed_model": "mixed model",
    "paired_t": "paired t",
    "holm": "Holm",
    "fisher_exact": "Fisher exact",
}
PACKAGES = {
    "signed_rank": "coin",
    "shift": "wilcox.test",
    "rank_biserial": "effectsize",
    "worst_rank": "coin",
    "crossover": "t.test, lmerTest",
    "anova": "car",
    "anova_type_ii": "car",
    "two_groupings": "car",
    "mixed_model": "lmerTest",
}
_LABEL = re.compile(r"^(?:(?P<kind>II|III) )?(?:.*: )(?P<quantity>\S+(?: .*)?)$")


@dataclass(frozen=True)
class Row:
    """One number that somebody else has computed, and ours."""

    test: str
    convention: str
    data: str
    source: str
    expected: float
    ours: float

    @property
    def difference(self) -> float:
        """Return the relative difference; of an expected 0, the absolute one."""
        return abs(self.ours - self.expected) / (abs(self.expected) or 1.0)


@cache
def rows() -> tuple[Row, ...]:
    """Return every number."""
    return (*_own(), *_published(), *_nist())


def _own() -> Iterator[Row]:
    for line in oracles.r_output():
        analysis = line["analysis"]
        name = oracles.SECOND_AUTHORITY.sub("", line["quantity"])
        ours = oracles.OURS[analysis](line["dataset"])[name]
        if not line["value"] or ours is None:
            continue
        expected = float(line["value"])
        if name.endswith(": huynh_feldt"):
            expected = min(expected, 1.0)  # R prints what it then takes for 1
        source = f"R, {PACKAGES.get(analysis, 'stats')}"
        convention = _convention(analysis, name)
        yield Row(TESTS[analysis], convention, line["dataset"], source, expected, float(ours))


def _convention(analysis: str, name: str) -> str:
    """Return a quantity without the names of the data's own effects and tests."""
    if analysis == "holm":
        return "adjusted p"
    found = _LABEL.match(name)
    if analysis == "mixed_model" and " " in name:
        return name.rpartition(" ")[2] + (" (omnibus)" if ": " in name and "−" not in name else "")
    return " ".join(filter(None, (found["kind"], found["quantity"]))) if found else name


def _published() -> Iterator[Row]:
    for line in published.r_output():
        design = line["convention"]
        if line["dataset"] != "sleep":
            design = design.rpartition(", ")[0]  # without the effect
        convention = f"{design}: {line['quantity']}"
        test = {"sleep": "paired tests"}.get(line["dataset"], "ANOVA, published data")
        expected = float(line["value"])
        if line["quantity"] == "huynh_feldt":
            expected = min(expected, 1.0)
        source = "R, afex and car" if "ANOVA" in test else "R, stats, coin, exactRankTests"
        yield Row(test, convention, line["dataset"], source, expected, published.ours(line))


def _nist() -> Iterator[Row]:
    for name in published.NIST_TOLERANCES:
        for quantity, expected in published.certified(name).items():
            ours = published.ours_of_nist(name)[quantity]
            yield Row("one-way ANOVA", quantity, name, "NIST StRD", expected, ours)


def accepted(row: Row) -> bool:
    """Return whether ours is what is expected, as closely as that can be known."""
    if row.data == "SmLs09":
        return row.difference <= published.NIST_TOLERANCES["SmLs09"]
    if row.convention.startswith("partial_eta_squared_"):  # R's noncentral beta stops at 1e-9
        return abs(row.ours - row.expected) <= max(1e-9, 1e-6 * abs(row.expected))
    return row.difference <= 1e-6


def worst() -> list[tuple[Row, int]]:
    """Return the row that is farthest off of each test and convention, and of how many."""
    groups: dict[tuple[str, str, str], list[Row]] = defaultdict(list)
    for row in rows():
        data = row.data if row.source.startswith("NIST") else ""
        groups[row.test, row.convention, data].append(row)
    return [(max(found, key=lambda row: row.difference), len(found)) for found in groups.values()]


def markdown() -> str:
    """Return the table."""
    lines = [
        "| test | convention or quantity | data set | expected by | expected | ours | "
        "relative difference | numbers compared |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row, compared in worst():
        convention = row.convention.replace("|", "\\|").replace("_", " ")
        lines.append(
            f"| {row.test} | {convention} | {row.data} | {row.source} | {row.expected:.9g} | "
            f"{row.ours:.9g} | {row.difference:.0e} | {compared} |"
        )
    return "\n".join(lines)


def in_page(table: str, begin: str, end: str) -> None:
    """Put a table between two marks of the page."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(begin)
    after = rest.partition(end)[2]
    PAGE.write_text(f"{before}{begin}\n\n{table}\n\n{end}{after}", encoding="utf-8")


def main() -> None:
    """Write the table into the page."""
    in_page(markdown(), BEGIN, END)
    largest = max(row.difference for row in rows() if row.data != "SmLs09")
    print(f"{len(rows())} numbers, {len(worst())} rows; largest relative difference {largest:.1e}")


if __name__ == "__main__":
    main()
