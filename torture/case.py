"""What every torture shares: its cases, what became of them, and their table."""

from __future__ import annotations

import math
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

TRACEBACK, HANG, OTHER = "traceback", "hang", "other"
_WORKERS = 2


@dataclass(frozen=True)
class Outcome:
    """What became of one case.

    Parameters
    ----------
    handed
        Rows that the recorder had taken so long before the cut that they must be there.
    lost
        Of these, how many are not.
    never_asked
        Items of a questionnaire that a finished session owes and does not have.
    fault
        `TRACEBACK`, `HANG` or `OTHER` (a wrong exit code, no sentence, a file that cannot be
        read); blank where there is none.
    detail
        What happened, for a person who looks into it.
    """

    name: str
    seed: int
    handed: int = 0
    lost: int = 0
    never_asked: int = 0
    fault: str = ""
    detail: str = ""

    @property
    def happened(self) -> str:
        """The outcome in a word or two."""
        if self.fault:
            return self.fault
        if self.lost:
            return "lost rows"
        return "never asked" if self.never_asked else "ok"


class Result(NamedTuple):
    """One torture's cases, and a sentence on how they came about.

    Parameters
    ----------
    planned
        How many there would have been in unlimited time.
    """

    name: str
    outcomes: Sequence[Outcome]
    how: str
    planned: int = 0

    @property
    def story(self) -> str:
        """How the cases came about, and whether there was time for all."""
        missing = self.planned - len(self.outcomes)
        return f"{self.how} No time was left for {missing} more cases." if missing > 0 else self.how

    def row(self) -> dict[str, Any]:
        """Return the torture's row in the table."""
        return {
            "torture": self.name,
            "cases": len(self.outcomes),
            "rows handed over": sum(each.handed for each in self.outcomes),
            "rows lost": sum(each.lost for each in self.outcomes),
            "items never asked": sum(each.never_asked for each in self.outcomes),
            "tracebacks": sum(each.fault == TRACEBACK for each in self.outcomes),
            "hangs": sum(each.fault == HANG for each in self.outcomes),
            "other faults": sum(each.fault == OTHER for each in self.outcomes),
        }

    @property
    def passed(self) -> bool:
        """Whether nothing was lost and nothing fell."""
        return bool(self.outcomes) and all(each.happened == "ok" for each in self.outcomes)


@dataclass(frozen=True)
class Rig:
    """Where tortures work, how much they may do, and the seed that all of their cases come from.

    Parameters
    ----------
    folder
        For files of cases; those of a case that went well are removed.
    short
        Few cases, for each change of the code.
    patient
        All cases, however long they take.
    """

    folder: Path
    seed: int = 0
    short: bool = False
    patient: bool = False
    began_s: float = field(default_factory=time.monotonic)

    def count(self, full: int, short: int) -> int:
        """Return how many cases there are."""
        return short if self.short else full

    def seeds(self, name: str, count: int) -> list[int]:
        """Return the seeds of a torture's cases: the same for the same seed and name."""
        root = np.random.SeedSequence([self.seed, zlib.crc32(name.encode())])
        return [int(each.generate_state(1)[0]) for each in root.spawn(count)]

    def place(self, name: str) -> Path:
        """Make and return a folder."""
        folder = self.folder / name
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def all(
        self, name: str, count: int, run: Callable[[int, int], Outcome], *, limit_s: float
    ) -> Iterator[Outcome]:
        """Run cases, two at a time; after `limit_s` no other begins, unless the rig is patient.

        Parameters
        ----------
        run
            Takes the number and the seed of a case.
        """
        end_s = math.inf if self.patient else time.monotonic() + limit_s

        def case(number: int, seed: int) -> Outcome | None:
            return run(number, seed) if time.monotonic() < end_s else None

        with ThreadPoolExecutor(_WORKERS) as pool:
            found = pool.map(case, range(count), self.seeds(name, count))
            yield from (outcome for outcome in found if outcome is not None)
