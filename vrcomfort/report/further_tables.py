"""Comparisons of groups, correlations, equivalence, preferences and agreement as flat rows."""

from __future__ import annotations

from typing import Any

Row = dict[str, Any]
_LISTS = ("participants", "sides", "values", "bounds", "shares")


def further_tables(results: Row) -> dict[str, list[Row]]:
    """Return the name of a table and its rows."""
    return {
        "comparisons": [_comparison(row) for row in results["comparisons"]],
        "correlations": [
            _plain(row) | {"people_in_it": row["participants"]} for row in results["correlations"]
        ],
        "equivalence": [
            _plain(row) | dict(zip(("bound_low", "bound_high"), row["bounds"], strict=True))
            for row in results["equivalence"]
        ],
        "preferences": [_preference(row) for row in results["preferences"]],
        "agreement": [line for row in results["agreement"] for line in _agreement(row)],
        "marginal_means": [line for found in results["mixed_models"] for line in _means(found)],
        "aligned_ranks": [
            {"outcome": found["outcome"]} | {key: effect[key] for key in _OF_RANKS}
            for found in results["anova"]
            for effect in found.get("aligned_ranks", ())
        ],
        "ordinal": [line for row in results["ordinal"] for line in _ordinal(row)],
        "ordinal_by_cut": [line for row in results["ordinal"] for line in _by_cut(row)],
        "z_scores": results["z_scores"],
        "kruskal_wallis": [_kruskal_wallis(row) for row in results["kruskal_wallis"]],
    }


_OF_RANKS = ("effect", "f", "df_effect", "df_error", "p", "p_greenhouse_geisser", "p_huynh_feldt")


def _means(found: Row) -> list[Row]:
    """Return marginal means and their differences, one line each."""
    if found["not_tested"]:
        return []
    return [
        {"outcome": found["outcome"], "factor": factor, "level": level, **estimate}
        for kind in ("means", "pairwise")
        for factor, levels in found[kind].items()
        for level, estimate in levels.items()
    ]


def _plain(row: Row) -> Row:
    return {key: value for key, value in row.items() if key not in _LISTS}


def _comparison(row: Row) -> Row:
    inner = {"difference", "effect", "descriptives", "simultaneous"}
    flat = {key: value for key, value in _plain(row).items() if key not in inner}
    n = row["n_a"]
    sides = (row["participants"][:n], row["participants"][-row["n_b"] :] if row["n_b"] else [])
    for side, people, where in zip("ab", sides, row["sides"], strict=True):
        flat |= {f"people_{side}": people}
        flat |= {f"{key}_{side}": where[key] for key in ("condition", "timepoint")}
    for side in ("a", "b"):
        described = row.get("descriptives", {}).get(side, {})
        flat |= {f"{key}_{side}": described.get(key) for key in ("mean", "sd", "median")}
    for part in ("difference", "effect"):
        found = row.get(part) or {}
        flat |= {f"{part}_{key}": found.get(key) for key in ("what", "estimate", "low", "high")}
        holm = (row["simultaneous"] or {}).get(part) or {}
        flat |= {f"{part}_holm_{key}": holm.get(key) for key in ("low", "high")}
    flat["confidence"] = (row.get("difference") or {}).get("confidence")
    return flat


def _preference(row: Row) -> Row:
    share = row["share_of_a"] or {}
    ends = {f"share_of_a_{key}": share.get(key) for key in ("low", "high")}
    return _plain(row) | {"share_of_a": share.get("estimate"), **ends}


def _agreement(row: Row) -> list[Row]:
    keys = {key: row[key] for key in ("outcome", "over", "condition", "not_tested")}
    sizes = {"n": row.get("n"), "people_in_it": row.get("participants")}
    return [{**keys, **sizes, **form} for form in row.get("forms", ())] or [keys]


def _kruskal_wallis(row: Row) -> Row:
    sizes = dict(zip(row.get("levels", ()), row.get("sizes", ()), strict=True))
    inner = {"levels", "sizes", "participants"}
    flat = {key: value for key, value in row.items() if key not in inner}
    flat["people_in_it"] = row.get("participants")
    return flat | {"groups": "; ".join(f"{name}: {n}" for name, n in sizes.items())}


def _ordinal(row: Row) -> list[Row]:
    """Return the odds ratios of a model, one line each."""
    keys = {key: row[key] for key in ("outcome", "instrument", "item", "not_tested")}
    if row["not_tested"]:
        return [keys]
    sizes = {"n_values": row["n_values"], "n_participants": row["n_participants"]}
    return [
        {**keys, **sizes, "term": term, **odds, "participant_sd": row["participant_sd"]}
        for term, odds in row["terms"].items()
    ]


def _by_cut(row: Row) -> list[Row]:
    """Return the odds ratio of answers above each cut, of each term."""
    return [
        {"outcome": row["outcome"], "term": term, "above": answer, "odds_ratio": ratio}
        for check in row.get("proportional", {}).values()
        for term, ratios in check["cuts"].items()
        for answer, ratio in zip(row["answers"][:-1], ratios, strict=True)
    ]
