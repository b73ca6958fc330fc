"""What the words around items' names say of when and under what they were asked."""

from __future__ import annotations

from collections.abc import Sequence

from vrcomfort.importing.suggest.draft import Doubt
from vrcomfort.importing.suggest.vocabulary import TIMEPOINTS

_COUNTED = {
    "session": ("session", "sess", "ses", "visit", "day", "sitzung", "termin", "tag"),
    "trial": ("trial", "run", "round", "exposure", "runde", "durchgang", "tr"),
    "period": ("period", "periode"),
    "block": ("block", "blk"),
}
_FACT_OF = {word: fact for fact, words in _COUNTED.items() for word in words}
_NUMBERED_TIMES = ("t", "time", "timepoint", "tp", "messzeitpunkt", "mzp", "wave", "zeitpunkt")
_KEPT = {*TIMEPOINTS, *_FACT_OF, *_NUMBERED_TIMES}
"""Words that say something even where all headings have them."""
_NOISE = frozenset(["ssq", "score", "item", "q", "question", "cond", "condition", "the", "vr"])


def moments(
    contexts: Sequence[tuple[str, ...]], *, numbers: str = "condition"
) -> tuple[list[dict[str, str]], list[Doubt]]:
    """Return for each questionnaire of a row the facts that its headings say, and doubts.

    Parameters
    ----------
    numbers
        The fact that numbers are taken for that stand alone.
    """
    if len(contexts) == 1:
        return _of_one(contexts[0])
    shared = set.intersection(*map(set, contexts))
    if any(set(context) <= shared for context in contexts) and max(map(len, contexts)) <= 4:
        shared = set()  # such as Blur and No Blur
    facts: list[dict[str, str]] = []
    doubts: list[Doubt] = []
    for context in contexts:
        rest = [w for w in context if w not in shared or w in _KEPT]
        facts.append(_facts(rest))
    _numbered_times(facts, doubts)
    _two_unnamed(facts, doubts)
    _name_the_rest(facts, doubts, numbers)
    return facts, doubts


def _of_one(context: tuple[str, ...]) -> tuple[list[dict[str, str]], list[Doubt]]:
    when = [TIMEPOINTS[word] for word in context if word in TIMEPOINTS]
    return [{"timepoint": when[0]} if len(set(when)) == 1 else {}], []


def _facts(words: Sequence[str]) -> dict[str, str]:
    facts: dict[str, str] = {}
    rest: list[str] = []
    place = 0
    while place < len(words):
        word = words[place]
        following = words[place + 1] if place + 1 < len(words) else ""
        if word in _FACT_OF and following.isdecimal():
            facts[_FACT_OF[word]] = following
            place += 1
        elif word in _NUMBERED_TIMES and following.isdecimal():
            facts["timepoint"] = f"t{following}"
            place += 1
        elif word in TIMEPOINTS and "timepoint" not in facts:
            facts["timepoint"] = TIMEPOINTS[word]
        elif word not in _FACT_OF and word not in _NOISE:
            rest.append(word)
        place += 1
    if rest:
        facts["condition"] = "_".join(rest)
    return facts


def _numbered_times(facts: list[dict[str, str]], doubts: list[Doubt]) -> None:
    """Call T0, T1, T2 baseline, post and recovery, and ask."""
    said = sorted({f["timepoint"] for f in facts if f.get("timepoint", "")[1:].isdecimal()})
    if not said:
        return
    names = dict(zip(said, ("baseline", "post", "recovery"), strict=False))
    for each in facts:
        when = each.get("timepoint", "")
        each["timepoint"] = names.get(when, when)
    shown = ", ".join(f"{old.upper()} {names.get(old, old)}" for old in said)
    doubts.append(Doubt("Which moments are T0, T1 …: before exposure, after it, later?", shown))


def _two_unnamed(facts: list[dict[str, str]], doubts: list[Doubt]) -> None:
    """Take two blocks of the same headings, the second marked with a number, for before, after."""
    bare = [f for f in facts if not f]
    second = [f for f in facts if set(f) == {"condition"} and f["condition"].isdecimal()]
    if len(facts) == 2 and len(bare) == 1 and len(second) == 1:
        bare[0]["timepoint"] = "baseline"
        second[0].pop("condition")
        second[0]["timepoint"] = "post"
        question = "The same items are asked twice in a row: are these before and after exposure?"
        doubts.append(Doubt(question, "the first columns are baseline, the second post"))


def _name_the_rest(facts: list[dict[str, str]], doubts: list[Doubt], fact: str) -> None:
    """Ask what numbers mean that stand alone; tell equal moments apart."""
    numbers = [f for f in facts if f.get("condition", "").replace("_", "").isdecimal()]
    if numbers:
        shown = ", ".join(dict.fromkeys(f["condition"] for f in numbers))
        question = f"What do the numbers {shown} in the headings stand for?"
        doubts.append(Doubt(question, f"each is a {fact}"))
        for each in numbers:
            each[fact] = each.pop("condition")
    several = len({f.get("condition", "") for f in facts}) > 1
    for place, each in enumerate(facts, start=1):
        nameless = several and "condition" not in each and each.get("timepoint") != "baseline"
        nameless = nameless and fact not in each
        if nameless or (not each and len(facts) > 1):
            each["condition"] = f"questionnaire_{place}"
            question = f"Of which condition is questionnaire {place} of a row?"
            doubts.append(Doubt(question, f"`questionnaire_{place}`"))
