"""Contradictions of what a report says: in results.json, its sentences and its tables."""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.support.random_studies import make
from tests.support.report import build_report
from vrcomfort.report.families import holds, is_shown

SHOWN = re.compile(r"higher (?:under|in) |lower (?:under|in) |more preferred|more of one went")
NOT_SHOWN = re.compile(r"no (?:difference|preference|correlation)\b.* (?:was|could be) shown")


def faults(folder: Path, seed: int) -> list[str]:
    """Report a random study; return what contradicts itself, or is out of its range."""
    source, plan = make(folder, seed)
    summary = build_report(source, plan=plan, out=folder / "o")
    results = json.loads(summary.results.read_text("utf-8"))
    page = summary.index.read_text("utf-8")
    alpha = round(1 - results["plan"]["confidence"], 12)
    return [
        *_contradicting_rows(results),
        *_contradicting_estimates(results, alpha),
        *_out_of_range(results),
        *_out_of_scale(results),
        *_contradicting_sentences(page, summary.headlines),
        *_contradicting_notices(results, summary.headlines),
        *_contradicting_tables(page, alpha),
        *(f"printed {each}" for each in ("nan", "inf", "None") if f">{each}<" in page),
    ]


class _Ends:
    """The ends of an interval of results.json."""

    def __init__(self, found: dict[str, Any]) -> None:
        self.low, self.high = found["low"], found["high"]
        self.low_closed = found.get("low_closed", True)
        self.high_closed = found.get("high_closed", True)
        self.holds_rejected_zero = found.get("holds_rejected_zero", False)


def _contradicting_rows(results: dict[str, Any]) -> Iterator[str]:
    """Yield the tests whose p, level, verdict and intervals differ about no difference."""
    alpha = round(1 - results["plan"]["confidence"], 12)
    for row in (*results["tests"], *results["comparisons"]):
        name = f"{row['outcome']} {row['a']} {row['b']}"
        if row["p"] is None:
            if row.get("verdict") is not None:
                yield f"{name}: a verdict without p"
            continue
        p = row["p"] if row["p_holm"] is None else row["p_holm"]
        shown = is_shown(row["verdict"])
        if shown != (p <= alpha) or shown != (row["p"] <= row["level"]):
            yield f"{name}: {row['verdict']} with p {row['p']}, {row['p_holm']} at {row['level']}"
        said = row["simultaneous"] or row
        for key in ("shift", "effect"):
            found = said.get(key)
            if not found or (found["low"], found["high"]) == (None, None):
                continue
            low, high = found["low"], found["high"]
            null = 0.5 if key == "effect" and row.get("test") == "sign" else 0.0  # a share
            if holds(_Ends(found), null) == shown:
                yield f"{name}: {row['verdict']}, {key} {low} to {high}"
            of_ranks = row.get("test") in {None, "signed_rank", "mann_whitney", "sign"}
            if key == "effect" and of_ranks and not -1 <= low <= found["estimate"] <= high <= 1:
                yield f"{name}: {key} {low} to {high}"
    for row in results.get("correlations") or ():
        known = row["p"] is not None and row["low"] is not None
        if known and holds(_Ends(row), 0.0) == (row["p"] <= alpha):
            yield f"correlation {row['x']} {row['y']}: {row['p']}, {row['low']}, {row['high']}"


RANGES = {"partial_eta_squared": (0, 1), "generalised_eta_squared": (0, 1), "share": (0, 1)}
PROBABILITIES = re.compile(r"^p$|^p_|^smallest_p$|^survival$|^kendall_w$")


def _out_of_range(found: Any, key: str = "") -> Iterator[str]:
    """Yield the numbers of results.json that cannot be: p, shares, ends in disorder."""
    if isinstance(found, list):
        for each in found:
            yield from _out_of_range(each, key)
    elif isinstance(found, dict):
        low, high = found.get("low"), found.get("high")
        if isinstance(low, int | float) and isinstance(high, int | float) and low > high:
            yield f"{key}: {low} to {high}"
        least, most = RANGES.get(key, (-math.inf, math.inf))
        for end in (low, high):
            if isinstance(end, int | float) and not least <= end <= most:
                yield f"{key}: an end at {end}"
        for name, value in found.items():
            if isinstance(value, float) and not math.isfinite(value):
                yield f"{name} is {value}"
            if (PROBABILITIES.search(name) and isinstance(value, int | float)
                    and not -1e-12 <= value <= 1 + 1e-12):  # fmt: skip
                yield f"{name} = {value}"
            yield from _out_of_range(value, name)


OTHER_NULL = {"share", "equivalence", "ordinal", "cox", "agreement", "preferences"}
"""Keys of what is compared with something else than 0, or with a p of something else."""


def _contradicting_estimates(found: Any, alpha: float, key: str = "") -> Iterator[str]:
    """Yield the estimates whose own p and interval differ about 0, wherever they stand."""
    if key in OTHER_NULL or key in {"tests", "comparisons"}:
        if key == "tests":
            for row in found:
                yield from _contradicting_estimates(row.get("t_test"), alpha, "t_test")
        return
    if isinstance(found, list):
        for each in found:
            yield from _contradicting_estimates(each, alpha, key)
    elif isinstance(found, dict):
        p = found.get("p_adjusted", found.get("p"))
        ends = found.get("low"), found.get("high")
        known = p is not None and ends != (None, None) and {"low", "high"} <= found.keys()
        if known and abs(p - alpha) > 1e-9 and holds(_Ends(found), 0.0) == (p <= alpha):
            yield f"{key}: p {p}, {ends[0]} to {ends[1]}"
        for name, value in found.items():
            yield from _contradicting_estimates(value, alpha, name)


MOST = {"T": 235.62, "N": 200.34, "O": 159.18, "D": 292.32, "ratings.peak": 20.0, "peak": 20.0,
        "mean": 20.0, "last": 20.0, "ratings.area": 20 * 80.0, "area": 20 * 80 / 60}  # fmt: skip
"""Of the SSQ and the FMS, whose ratings come from 10 s to 90 s."""


def _out_of_scale(results: dict[str, Any]) -> Iterator[str]:
    """Yield the bounds that no score, mean, difference or rating can have."""
    changes = results["score_basis"] == "difference_from_baseline"
    for row in results["descriptives"]:
        name, most = row["outcome"], MOST[row["outcome"]]
        least = -most if changes and not name.startswith("ratings.") else 0.0
        yield from _beyond(
            f"mean of {name}", row.get("mean_low"), row.get("mean_high"), least, most
        )
    for row in (*results["tests"], *results["comparisons"], *results["equivalence"]):
        most = MOST[row["outcome"]] * (2 if changes else 1)
        for found in (row, row.get("simultaneous"), row.get("t_test")):
            for each in (found and found.get("shift"), found and found.get("difference"),
                         found if row.get("t_test") is found else None):  # fmt: skip
                if isinstance(each, dict):
                    yield from _beyond(
                        f"difference of {row['outcome']}", each["low"], each["high"], -most, most
                    )
    models = [(row["outcome"], row) for row in results["mixed_models"]]
    models += [(row["summary"], row) for row in (results.get("ratings") or {}).get("models", ())]
    for name, row in models:
        most = MOST.get(name, math.inf) * (2 if changes else 1)
        for each in (row.get("terms") or {}).values():
            yield from _beyond(f"effect on {name}", each["low"], each["high"], -most, most)
        for levels in (row.get("means") or {}).values():
            for each in levels.values():
                least = -most if changes or most == math.inf else 0.0
                yield from _beyond(
                    f"marginal mean of {name}", each["low"], each["high"], least, most
                )
    for row in results["agreement"]:
        for form in row.get("forms") or ():
            least = -math.inf if form["form"].endswith("k") else -1.0
            yield from _beyond(f"ICC({form['form']})", form["low"], form["high"], least, 1.0)
    for point in (results.get("ratings") or {}).get("curves", ()):
        yield from _beyond("mean curve", point["low"], point["high"], 0.0, 20.0)


def _beyond(
    what: str, low: float | None, high: float | None, least: float, most: float
) -> Iterator[str]:
    slack = 1e-6 * most if math.isfinite(most) else 0.0
    for end in (low, high):
        if end is not None and not least - slack <= end <= most + slack:
            yield f"{what}: an end at {end}, which is not from {least} to {most}"


INTERVAL = re.compile(
    r"(?P<left>[\[(])(?P<low>[−\d.∞]+),\u00a0(?P<high>[−\d.∞]+)(?P<right>[\])])"
    r"(?P<hole> without 0)?"
)


def _contradicting_sentences(page: str, headlines: tuple[str, ...]) -> Iterator[str]:
    """Yield sentences of page and terminal beside an interval that says another thing."""
    answers = re.findall(
        r'<p class="answer[^>]*>(.*?)</p>(?:\s*<p class="evidence">(.*?)</p>)?', page, re.S
    )
    said = [[html.unescape(re.sub(r"<[^>]+>", "", part)) for part in pair] for pair in answers]
    together = [(claim, f"{claim} {evidence}") for claim, evidence in said]
    for claim, evidence in (*together, *((line, line) for line in headlines)):
        shown, not_shown = SHOWN.search(claim), NOT_SHOWN.search(claim)
        if bool(shown) == bool(not_shown):
            continue
        for found in INTERVAL.finditer(evidence):
            before = evidence[max(0, found.start() - 40) : found.start()]
            if "share" in before or "unadjusted" in before:
                continue
            if _holds_zero(found) == bool(shown):
                yield f"{claim} | {found[0]}"


def _contradicting_notices(results: dict[str, Any], headlines: tuple[str, ...]) -> Iterator[str]:
    """Yield notices on the primary outcome beside an answer that says another thing."""
    answers = " ".join(headlines)
    if results["without_primary"] and "vrsq" in results["plan"]["outcomes"][0]:
        titles = [each["title"] for each in results["outcomes"]]
        if any("VRSQ" in title for title in titles):
            yield "the missing primary outcome is analysed"
    primary = next((each["title"] for each in results["outcomes"]), "")
    said = [line.removeprefix("Secondary: ") for line in headlines]
    mine = [line for line in said if line.startswith(f"{primary}:")]
    for notice in results["notices"]:
        if "whatever they answered, no difference" in notice and any(SHOWN.search(x) for x in mine):
            yield f"{notice} | {answers}"
        if " is the same under " in notice and not any(
            "nobody’s score differed" in x for x in mine
        ):
            yield f"{notice} | {answers}"


NO_ZERO = re.compile(
    r"preference|odds|equivalence|agreement|intraclass|share|survival|time to|hazard|smallest", re.I
)  # fmt: skip


def _contradicting_tables(page: str, alpha: float) -> Iterator[str]:
    """Yield the rows of the page's tables whose p and interval differ about 0."""
    for table in re.findall(r"<table.*?</table>", page, re.S):
        caption = re.search(r"<caption>(.*?)</caption>", table, re.S)
        text = html.unescape(re.sub(r"<[^>]+>", "", caption[1] if caption else ""))
        heads = [
            html.unescape(re.sub(r"<[^>]+>", "", h))
            for h in re.findall(r"<th[^>]*>(.*?)</th>", table, re.S)
        ]
        ends = [place for place, head in enumerate(heads) if head.endswith("CI")]
        if NO_ZERO.search(text) or not ends or "p" not in heads:
            continue
        for row in re.findall(r"<tr[^>]*>(.*?)</tr>", table, re.S):
            cells = [
                html.unescape(re.sub(r"<[^>]+>", "", cell))
                for cell in re.findall(r"<td[^>]*>(.*?)</td>", row, re.S)
            ]
            if len(cells) != len(heads):
                continue
            p = cells[heads.index("p Holm")] if "p Holm" in heads else "–"
            p = cells[heads.index("p")] if p == "–" else p
            number = re.search(r"\d*\.\d+", p)
            if not number or ("<" not in p and abs(float(number[0]) - alpha) < 0.002):
                continue
            for place in ends:
                found = INTERVAL.fullmatch(cells[place])
                shown = float(number[0]) <= alpha
                other = "share above" in cells[place - 1]  # of which no difference is a half
                if found and not other and _holds_zero(found) == shown:
                    yield f"{text}: {' | '.join(cells)}"


def _holds_zero(found: re.Match[str]) -> bool:
    low, high = (float(found[end].replace("−", "-").replace("∞", "inf")) for end in ("low", "high"))
    above = low < 0 or (low == 0 and found["left"] == "[")
    below = high > 0 or (high == 0 and found["right"] == "]")
    return above and below and not found["hole"]
