"""Coverage of intervals of the fast–slow model on simulated courses."""

from __future__ import annotations

import numpy as np

from vrcomfort.stats.rating_courses import RatingCourse, fit_symptoms, symptom_course

COURSES = ((1800, 30), (600, 60), (600, 10))
"""Length and time between ratings, in seconds."""
LEVEL, SENSITISATION = 4.0, 1.5
SD, CORRELATION = 0.3, 0.5
TIMES = 200


def main() -> None:
    """Print a row for each kind of course."""
    print("course  held level  held sensitisation  median level  median sensitisation")
    for length_s, every_s in COURSES:
        at_s = np.arange(every_s, length_s + 1, every_s)
        random = np.random.default_rng(11)
        held, found = [], []
        for _ in range(TIMES):
            noise = np.zeros(at_s.size)
            for place in range(1, at_s.size):
                noise[place] = CORRELATION * noise[place - 1] + random.normal(0, SD)
            ratings = symptom_course(at_s, LEVEL, SENSITISATION) + noise
            fit = fit_symptoms([("a", RatingCourse.of(at_s, ratings))])
            level, h = fit.levels["a"], fit.sensitisation
            known = h.low is not None and h.high is not None
            holds_h = not known or (h.low or 0.0) <= SENSITISATION <= (h.high or 0.0)
            holds_level = (level.low or 0.0) <= LEVEL <= (level.high or np.inf)
            held.append((holds_level, holds_h))
            found.append((level.estimate, h.estimate))
        shares, medians = np.mean(held, axis=0), np.median(found, axis=0)
        numbers = "  ".join(f"{value:.3f}" for value in (*shares, *medians))
        print(f"{length_s} s every {every_s} s  {numbers}")


if __name__ == "__main__":
    main()
