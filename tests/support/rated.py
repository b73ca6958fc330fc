"""Studies of ratings during exposure, written as files: who rated what when, and who left."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vrcomfort.records.rows import cell_text, csv_line

RATINGS = (
    "participant", "session", "trial", "condition", "onset_s", "latency_s", "instrument",
    "response", "missed", "resumed",
)  # fmt: skip
TRIALS = (
    "participant", "session", "period", "block", "trial", "condition", "scene", "start_s", "end_s",
    "status", "abort_code", "attempt", "resumed", "frames", "dropped", "missed_refreshes", "live_s",
    "frozen_s", "hidden_s", "unfocused_s",
)  # fmt: skip
GAP_S = 100.0
"""Between the beginnings of two exposures, and before the first."""


@dataclass
class RatedStudy:
    """Collects rows, and writes them as a study folder of one file each."""

    trials: list[tuple[object, ...]] = field(default_factory=list)
    ratings: list[tuple[object, ...]] = field(default_factory=list)

    def expose(
        self, who, condition, ratings, *, every_s=10.0, ended_s=None, status="completed", lost_s=0.0
    ):
        """Add an exposure; a rating of None was missed."""
        trial = 1 + sum(row[0] == who for row in self.trials)
        start = GAP_S * 20 * trial
        length = every_s * (len(ratings) + 1) if ended_s is None else ended_s
        self.trials.append(
            (who, 1, trial, 1, trial, condition, "temple", start, start + length, status, "", 1, 0,
             1000, 0, 0, length - lost_s, lost_s, 0.0, 0.0)
        )  # fmt: skip
        for place, rating in enumerate(ratings, start=1):
            self.ratings.append(
                (who, 1, trial, condition, start + every_s * place, None, "fms", rating,
                 int(rating is None), 0)
            )  # fmt: skip
        return self

    def write(self, folder: Path) -> Path:
        """Write the study, and return its folder."""
        folder.mkdir(parents=True, exist_ok=True)
        left = {row[0] for row in self.trials if row[9] == "withdrawn"}
        people = dict.fromkeys(row[0] for row in self.trials)
        rows = [(who, "", "withdrawn" if who in left else "completed", "", "") for who in people]
        header = ("participant", "sequence", "status", "enrolled_at", "note")
        _write(folder / "participants.csv", header, rows)
        _write(folder / "trials.csv", TRIALS, self.trials)
        _write(folder / "ratings.csv", RATINGS, self.ratings)
        return folder


def _write(file, header, rows):
    lines = [csv_line(header), *(csv_line(map(cell_text, row)) for row in rows)]
    file.write_text("".join(lines), encoding="utf-8")


def with_drop_outs(people=16, minutes=8, seed=5) -> RatedStudy:
    """Return two conditions, one worse than the other, whom the sickest leave early."""
    random = np.random.default_rng(seed)
    study = RatedStudy()
    for person in range(people):
        own = random.normal(0, 1.5)
        order = ("sharp", "blurred") if person % 2 else ("blurred", "sharp")
        gone = False
        for place, condition in enumerate(order):
            if gone:
                break
            pace = (1.6 if condition == "sharp" else 1.0) + 0.12 * own
            ratings: list[int | None] = []
            for minute in range(1, 2 * minutes):
                level = pace * minute / 2 + own + 0.4 * place + random.normal(0, 0.7)
                ratings.append(None if random.random() < 0.05 else int(np.clip(level, 0, 20)))
                gone = level > 11.5
                if gone:
                    break
            study.expose(
                f"P{person + 1:02}",
                condition,
                ratings,
                every_s=30.0,
                ended_s=30.0 * len(ratings) + 12.0 if gone else 60.0 * minutes,
                status="withdrawn" if gone else "completed",
            )
    return study
