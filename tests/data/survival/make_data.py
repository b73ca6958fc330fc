"""Makes the data sets for tests of survival analysis against R; nothing in them is anybody's."""

from pathlib import Path

import numpy as np
import pandas as pd

COLUMNS = ["dataset", "participant", "condition", "position", "time_s", "event"]


def courses(name, *, people, conditions, scales, end_s, step_s, frailty, seed):
    """Return exposures that end at `end_s` at the latest; times are multiples of `step_s`."""
    random = np.random.default_rng(seed)
    rows = []
    for person in range(people):
        share = random.gamma(1 / frailty, frailty) if frailty else 1.0
        for position, place in enumerate(random.permutation(len(conditions)), start=1):
            time = scales[place] * random.exponential() / share
            left = random.uniform(0.3 * end_s, 1.3 * end_s)
            seen = min(time, left, end_s)
            seen = max(np.ceil(seen / step_s) * step_s, step_s)
            event = int(time <= min(left, end_s))
            rows.append((name, f"P{person + 1:02}", conditions[place], position, seen, event))
    return pd.DataFrame(rows, columns=COLUMNS)


def main():
    """Write data.csv beside this file."""
    sets = [
        courses(
            "independent",
            people=40,
            conditions=["a"],
            scales=[200],
            end_s=300,
            step_s=1,
            frailty=0,
            seed=1,
        ),
        courses(
            "two_conditions",
            people=24,
            conditions=["a", "b"],
            scales=[120, 260],
            end_s=240,
            step_s=5,
            frailty=0.6,
            seed=2,
        ),
        courses(
            "three_with_ties",
            people=15,
            conditions=["a", "b", "c"],
            scales=[90, 150, 300],
            end_s=180,
            step_s=30,
            frailty=1.0,
            seed=3,
        ),
        courses(
            "few_events",
            people=10,
            conditions=["a", "b"],
            scales=[900, 1500],
            end_s=300,
            step_s=2,
            frailty=0.3,
            seed=4,
        ),
        courses(
            "everybody",
            people=6,
            conditions=["a", "b"],
            scales=[20, 30],
            end_s=900,
            step_s=1,
            frailty=0,
            seed=5,
        ),
    ]
    file = Path(__file__).with_name("data.csv")
    pd.concat(sets).to_csv(file, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
