"""What the methods section says of ratings over time and of times to events."""

from __future__ import annotations

from typing import Any

Results = dict[str, Any]
Paragraph = tuple[str, str, tuple[str, ...]]
"""Title, text, and the keys of what it cites."""


def course_paragraphs(results: Results) -> list[Paragraph]:
    """Return the paragraphs on what was made of courses in this report."""
    ratings = results["ratings"]
    rated = ratings is not None and bool(ratings["curves"])
    events = [*(ratings["reached"][:1] if rated else []), results["leaving"]]
    made = [event for event in events if event]
    return [
        *([_courses(ratings, several=len(ratings["conditions"]) > 1)] if rated else []),
        *([_survival(made)] if made else []),
        *([_symptom_model(ratings["symptom_model"])] if rated and ratings["symptom_model"] else []),
    ]


def _courses(ratings: Results, *, several: bool) -> Paragraph:
    text = (
        "Each course of ratings is summed up by one number (Matthews et al., 1990), which a mixed "
        "model with a random intercept for each participant takes as its outcome. Times are live "
        "ones, where they were recorded. "
    )
    cited = ["matthews_1990"]
    if several:
        text += (
            "At each time, the means of conditions are those of such a model of the last ratings "
            "then, and their intervals compare conditions within people: the variance of a mean’s "
            "distance from the mean of all k conditions times k/(k − 1), which is Cousineau’s "
            "(2005) with Morey’s (2008) correction and, where nothing is missing, the interval of "
            "Loftus and Masson (1994). "
        )
        cited += ["cousineau_2005", "morey_2008", "loftus_1994"]
    if ratings["sensitivity"]:
        text += (
            "Models are repeated of completed exposures alone, and with the last rating, or the "
            "highest answer, standing from leaving until the planned end."
        )
    return "Ratings during exposure", text.strip(), tuple(cited)


def _survival(made: list[Results]) -> Paragraph:
    again = any(event["repeated"] for event in made)
    text = (
        "Times to events are Kaplan–Meier estimates (1958) with Greenwood’s error and intervals "
        "of the logarithm of survival; groups are compared by log-rank tests (Mantel, 1966) and "
        "by Cox’s (1972) proportional hazards with Efron’s (1977) treatment of ties, of condition "
        "and order."
    )
    cited = ["kaplan_1958", "mantel_1966", "cox_1972", "efron_1977"]
    if again:
        text += (
            " As people come more than once, log-rank tests are made within people as well (each "
            "one a stratum), and errors of hazard ratios and of curves are robust: scores and "
            "influences are summed within people (Lin & Wei, 1989)."
        )
        cited.append("lin_1989")
    return "Time to events", text, tuple(cited)


def _symptom_model(found: Results) -> Paragraph:
    constants = found["constants"]
    text = (
        f"Oman’s (1990) model has a fast ({constants['fast_s']:g} s) and a slow "
        f"({constants['slow_s']:g} s) path of second order, the slow one making the fast one more "
        f"sensitive, and a power law of exponent {constants['exponent']:g} (Irmak et al., 2022). "
        "It was fitted to each person by least squares, with a level for each condition and one "
        "sensitisation; its errors allow for residuals that correlate in time. Each exposure is "
        "taken to begin without symptoms and to be as strong from its start to its end."
    )
    return "Model of symptoms", text, ("oman_1990", "irmak_2022")
