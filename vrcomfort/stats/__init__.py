"""Statistics of comfort studies.

`vrcomfort.stats.wilcoxon`, `mwu`, `ttest`, `friedman`, `kruskal`, `rm_anova`, `art_anova`,
`mixed_model`, `ordinal_model`, `crossover`, `corr`, `icc`, `kaplan_meier`, `log_rank`, `cox` and
`holm` take tidy data frames and return data frames. They are in `data_frames`, which is imported
when one of them is first named.

The modules below them take arrays and return dataclasses, and can each be used alone: `signed_rank`
(exact with ties), `shift` (Hodges-Lehmann), `effects` (effect sizes with intervals), `multiplicity`
(Holm), `anova`, `mixed`, `rank_anova`, `ordinal`, `survival`, `rating_courses`, `gaze_and_head`.
"""

from importlib import import_module
from typing import Any

# No name equals that of a module of this package, whose import would replace it.
__all__ = [
    "art_anova",
    "corr",
    "cox",
    "crossover",
    "friedman",
    "holm",
    "icc",
    "kaplan_meier",
    "kruskal",
    "log_rank",
    "mixed_model",
    "mwu",
    "ordinal_model",
    "rm_anova",
    "ttest",
    "wilcoxon",
]


def __getattr__(name: str) -> Any:
    """Import the functions of data frames when one of them is named."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module("vrcomfort.stats.data_frames"), name)
    return found


def __dir__() -> list[str]:
    """Return all names, those that are not imported yet among them."""
    return sorted({*globals(), *__all__})
