"""Random studies and plans, and the contradictions of what a report says of them."""

from __future__ import annotations

import html
import json
import math
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.support.report import Study, build_report, foreign, write_csv
from vrcomfort.report.families import holds, is_shown

SHOWN = re.compile(r"higher (?:under|in) |lower (?:under|in) |more preferred|more of one went")
NOT_SHOWN = re.compile(r"no (?:difference|preference|correlation)\b.* (?:was|could be) shown")
HEADING = 'name = "p"\ntitle = "P"\noutcomes = ["T", "N", "O", "D"]\n'
PAIR = '[[contrasts]]\na = "a"\nb = "b"\n'
GROUPS = '[[contrasts]]\na = "x"\nb = "y"\nbetween = "group"\n'
DESIGNS = (
    "",
    PAIR,
    f'{PAIR}[[contrasts]]\na = "b"\nb = "a"\ntest = "paired_t"\n',
    f'{GROUPS}{GROUPS}test = "welch_t"\n[[correlations]]\nx = "T"\ny = "N"\nmethod = "pearson"\n'
    '[[correlations]]\nx = "N"\ny = "D"\n',
    f'{PAIR}test = "sign"\n[[correlations]]\nx = "O"\ny = "D"\nmethod = "kendall"\n',
)
CHOICES = ("", "", 'zeros = "wilcox"\n', 'alternative = "greater"\n', 'p_value = "asymptotic"\n',
           "confidence = 0.9\n", 'withdrawals = "available_pairs"\n', 'sums_of_squares = "II"\n',
           'mixed_model_errors = "model"\n')  # fmt: skip
FAMILIES = ("", '[[families]]\nname = "all"\noutcomes = ["T", "N", "O", "D"]\n',
            '[[families]]\nname = "parts"\noutcomes = ["N", "O", "D"]\n')  # fmt: skip


def make(folder: Path, seed: int) -> tuple[Path, Path | None]:
    """Write a random study and its plan; without a plan in a third of them."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    conditions = "abcdefgh"[: chance.choice((1, 2, 2, 2, 3, 4, 8))]
    people = [f"P{i:02d}" for i in range(chance.choice((1, 2, 3, 5, 6, 8, 12, 20, 40)))]
    values = chance.choice(((0, 0, 0, 1, 5), (0, 1, 2, 5, 11, 30), (4,), (0, 48), range(20)))
    effect = chance.choice((0, 0, 2, 6, 15))
    scores = {
        who: {
            name: min(48, chance.choice(values) + effect * place)
            for place, name in enumerate(conditions)
            if chance.random() > 0.05
        }
        for who in people
    }
    source = folder / "s"
    if chance.random() < 0.5:
        _recorded(source, scores, chance)
    else:
        _from_elsewhere(source, scores, chance)
    if chance.random() < 1 / 3:
        return source, None
    design = chance.choice(DESIGNS if len(conditions) > 1 else DESIGNS[:1])
    plan = folder / "plan.toml"
    text = HEADING + chance.choice(CHOICES) + design
    plan.write_text(text + (chance.choice(FAMILIES) if "families" not in text else ""), "utf-8")
    return source, plan


def _from_elsewhere(source: Path, scores: dict[str, dict[str, int]], chance: random.Random) -> None:
    foreign(source / "questionnaires.csv", scores)
    rows = [{"participant": who, "status": "completed", "group": chance.choice("xy")}
            for who in scores]  # fmt: skip
    write_csv(source / "participants.csv", ("participant", "status", "group"), rows)


def _recorded(source: Path, scores: dict[str, dict[str, int]], chance: random.Random) -> None:
    study, leave = Study(source), chance.choice((0, 0, 0.1, 0.4))
    study.describe("tiny")
    base = chance.choice((None, 0, 2))
    for who, each in scores.items():
        order = list(each.items())
        chance.shuffle(order)
        exposures: list[tuple[str, str, int | None]] = [(c, "x", t) for c, t in order]
        gone = bool(exposures) and chance.random() < leave
        if gone:
            exposures = exposures[: chance.randint(1, len(exposures))]
            exposures[-1] = (exposures[-1][0], "x", None)
        status = "withdrawn" if gone else "completed"
        if exposures:
            study.session(who, 1, base, exposures, status=status)
        study.person(who, "s", status)
    file = source / "participants.csv"
    lines = file.read_text("utf-8").splitlines()
    lines = [f"{lines[0]},group", *(f"{line},{chance.choice('xy')}" for line in lines[1:])]
    file.write_text("\n".join(lines) + "\n", "utf-8")


def faults(folder: Path, seed: int) -> list[str]:
    """Report a random study; return what contradicts itself, or is out of its range."""
    source, plan = make(folder, seed)
    summary = build_report(source, plan=plan, out=folder / "o")
    results = json.loads(summary.results.read_text("utf-8"))
    page = summary.index.read_text("utf-8")
    return [
        *_contradicting_rows(results),
        *_out_of_range(results),
        *_contradicting_sentences(page, summary.headlines),
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
    alpha = 1 - results["plan"]["confidence"]
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


INTERVAL = re.compile(
    r"(?P<left>[\[(])(?P<low>[−\d.∞]+),\u00a0(?P<high>[−\d.∞]+)(?P<right>[\])])"
    r"(?P<hole> without 0)?"
)


def _contradicting_sentences(page: str, headlines: tuple[str, ...]) -> Iterator[str]:
    """Yield sentences of page and terminal beside an interval that says another thing."""
    top = page[: page.index('id="tests"')]
    answers = re.findall(
        r'<p class="answer[^>]*>(.*?)</p>\s*<p class="evidence">(.*?)</p>', top, re.S
    )
    said = [(html.unescape(re.sub(r"<[^>]+>", "", part)) for part in pair) for pair in answers]
    for claim, evidence in (*said, *((line, line) for line in headlines)):
        shown, not_shown = SHOWN.search(claim), NOT_SHOWN.search(claim)
        if bool(shown) == bool(not_shown):
            continue
        for found in INTERVAL.finditer(evidence):
            before = evidence[max(0, found.start() - 40) : found.start()]
            if "share" in before or "unadjusted" in before:
                continue
            low, high = (
                float(found[end].replace("−", "-").replace("∞", "inf")) for end in ("low", "high")
            )
            above = low < 0 or (low == 0 and found["left"] == "[")
            below = high > 0 or (high == 0 and found["right"] == "]")
            if (above and below and not found["hole"]) == bool(shown):
                yield f"{claim} | {found[0]}"
