"""Analysis plans: contrasts, tests, families. Read from TOML.

A plan is a pre-registration in code: everything that a report decides stands in it, and what a
report had to do otherwise is told (`deviations`).
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr

from vrcomfort.errors import InputError
from vrcomfort.report.measures import Limit, MeasureSettings
from vrcomfort.report.plan.data_files import DataFiles
from vrcomfort.settings import Name, Settings
from vrcomfort.settings.locate import locate

TestName = Literal["signed_rank", "paired_t", "sign", "mann_whitney", "welch_t", "student_t"]
PAIRED = ("signed_rank", "paired_t", "sign")
INDEPENDENT = ("mann_whitney", "welch_t", "student_t")
Side = Literal["two-sided", "greater", "less"]
FigureName = Literal[
    "paired", "subscales", "symptoms", "recovery", "flow", "exposures", "residuals"
]
"""Those of analyses are added by `plan_files`."""
TrialMeasure = Literal[
    "frames", "dropped", "dropped_percent", "missed_refreshes", "length_s", "live_s", "frozen_s",
    "hidden_s", "unfocused_s", "seen_s", "off_s", "not_drawn_s", "half_rate_s", "untracked_s",
]  # fmt: skip
Participants = Annotated[int, Field(ge=1, le=1_000_000)]


class Entry(Settings):
    """An entry of an analysis' key in a plan; its fields are those of the analysis."""

    @property
    def of_choices(self) -> str:
        """Return the questionnaire with choices instead of scores; blank: none."""
        return ""


class Contrast(Settings):
    """Two sides that the same people met, or two groups; differences are `a` minus `b`.

    A side is a condition, at the plan's exposure timepoint unless another is given. A side without
    a condition is that timepoint whatever the condition: `a_timepoint = "post"`, `b_timepoint =
    "baseline"` compares before and after.
    """

    a: str = ""
    b: str = ""
    a_timepoint: str = ""
    b_timepoint: str = ""
    between: str = ""
    """Blank: the same people met both. Else the column whose values `a` and `b` are: one of
    participants.csv, `group`, `sequence`, or `condition` where each met one of the two."""
    condition: str = ""
    """Of a contrast between groups: of which exposures; blank: of all."""
    test: TestName | None = None
    """None: signed_rank of pairs, mann_whitney of groups."""
    alternative: Side | None = None
    """None: that of the plan."""


class Factor(Settings):
    """A factor of the ANOVA."""

    name: str
    column: str
    """condition, scene, position, session, timepoint or part; or, between participants, sequence,
    group or any column of participants.csv."""
    kind: Literal["within", "between"] | None = None
    """None: within participants for the first six of these columns, between them for others."""
    levels: dict[str, str] = Field(default_factory=dict)
    """Value of the column → level of the factor; values not listed keep their name."""


class Family(Settings):
    """A family of tests: their p values are adjusted together."""

    name: Name
    outcomes: Annotated[tuple[str, ...], Field(min_length=1)]
    analyses: Annotated[tuple[Literal["tests", "anova"], ...], Field(min_length=1)] = ("tests",)
    """`tests`: every contrast of these outcomes; `anova`: every effect of their ANOVA."""
    method: Literal["holm", "none"] = "holm"


class Exclusion(Settings):
    """A rule by which a participant, or an exposure, is left out; decided before the data."""

    name: Name
    reason: str = ""
    removes: Literal["participant", "exposure"] = "participant"
    participants: tuple[str, ...] = ()
    """Names of people, for what only the experimenter knows."""
    score: str = ""
    """A score at `timepoint`; an exposure's own where that is the exposure timepoint."""
    timepoint: str = ""
    trial: TrialMeasure | None = None
    """A measure of an exposure in trials.csv."""
    column: str = ""
    """A column of participants.csv."""
    above: Limit | None = None
    below: Limit | None = None
    equals: tuple[str, ...] = ()


class Plan(Settings):
    """One analysis, decided before the data are seen.

    The keys of single analyses are added by `plan_files`, from the analyses themselves.
    """

    name: Name
    title: str
    citation: str = ""
    note: str = ""
    """A sentence about the choices made, printed with the methods."""
    data: DataFiles | None = None
    """Whose answers, where no study is given to ``vrcomfort report``."""
    participants: Participants | None = None
    """Planned number; fewer in the data is a deviation."""

    outcomes: tuple[str, ...] = ()
    """Scores of any instrument, and measures, by name; the first is the primary one. Empty: every
    score of what was asked after exposures."""
    measures: tuple[MeasureSettings, ...] = ()
    """Names, labels, units and directions of measures."""
    scores: Literal["difference_from_baseline", "raw"] = "difference_from_baseline"
    """What conditions are compared on. Without any baseline in the data they are raw."""
    missing_items: Literal["leave_out", "prorate"] = "leave_out"
    """`leave_out`: an incomplete questionnaire is not scored. `prorate`: missing items of a score
    count as the mean of its answered ones, where enough are answered (`min_answered`)."""
    min_answered: Annotated[float, Field(gt=0, le=1)] = 0.8
    """Share of a questionnaire's items that must be answered to prorate."""
    baseline_timepoint: str = "baseline"
    exposure_timepoint: str = "post"
    recovery_timepoint: str = "recovery"

    contrasts: tuple[Contrast, ...] = ()
    """Empty: every pair of conditions, in the order of the protocol."""
    alternative: Side = "two-sided"
    """`greater`: higher scores under a."""
    zeros: Literal["pratt", "wilcox"] = "pratt"
    p_value: Literal["exact", "asymptotic"] = "exact"
    """`exact`: where the number of pairs allows it, with ties and zeros."""
    shift_interval: Literal["inverted_test", "order_statistics"] = "inverted_test"
    """`inverted_test`: every shift that the printed test does not reject. `order_statistics`: of
    the Walsh averages, as R's ``wilcox.test`` has it; it may contradict p where there are ties."""
    rank_biserial_interval: Literal["normal_shift", "effectsize", "nonzero_differences"] = (
        "normal_shift"
    )
    """`normal_shift`: by inversion over normal differences. The others are Fisher-z intervals, too
    narrow where there is an effect; they differ in the n of the standard error. R's ``effectsize``
    counts the non-zero scores of condition a; the formula is for the non-zero differences."""
    confidence: Annotated[float, Field(gt=0.5, lt=1)] = 0.95
    families: tuple[Family, ...] = ()
    """Outcomes in no family are not adjusted."""

    withdrawals: Literal["complete_pairs", "available_pairs", "worst_rank"] = "complete_pairs"
    """Who is in a test: with every planned exposure of both sides; with any of both; or everybody,
    a withdrawal being ranked as worse than anything that was answered."""
    exclusions: tuple[Exclusion, ...] = ()

    anova: tuple[Factor, ...] = (
        Factor(name="condition", column="condition"),
        Factor(name="scene", column="scene"),
    )
    """Factors that have one level in the data are left out."""
    sums_of_squares: Literal["II", "III"] = "III"
    aligned_ranks: bool = False
    """Whether the effects of the ANOVA are tested on aligned ranks as well."""
    mixed_model: tuple[str, ...] = ("condition", "scene", "position", "session")
    """Fixed effects of the model of all available data, the most wanted first."""
    mixed_model_errors: Literal["cluster_robust", "model"] = "cluster_robust"
    """Standard errors of mixed models, those of ratings too: `cluster_robust` ones (CR2) hold their
    level with few people and skewed scores; those of the `model` are lme4's."""
    covariates: tuple[str, ...] = ()
    """Columns of participants.csv with numbers, added to the mixed model."""
    smallest_effect_power: Annotated[float, Field(ge=0.1, le=0.99)] | None = None
    """Say which effect the primary tests would have found with this power, at their number of
    pairs; None: do not."""
    figures: tuple[FigureName, ...] = ()
    """Figures wanted; empty: every one that the data allow."""

    _text: str = PrivateAttr(default="")
    _file: Path | None = PrivateAttr(default=None)

    @property
    def of_choices(self) -> frozenset[str]:
        """Return the questionnaires that compare conditions and are counted as preferences."""
        entries = [each for key in type(self).model_fields for each in self.entries(key)]
        return frozenset(each.of_choices for each in entries if isinstance(each, Entry)) - {""}

    def entries(self, key: str) -> tuple[Any, ...]:
        """Return the entries of an analysis' key, which is a list; none where it has no key."""
        found = getattr(self, key, ())
        return found if isinstance(found, tuple) else ()

    @property
    def needs_every_score(self) -> bool:
        """Return whether an analysis is of participants with every planned score alone."""
        return self.withdrawals != "available_pairs"

    @property
    def text(self) -> str:
        """Return the TOML text that this was read from."""
        return self._text

    @property
    def file(self) -> Path | None:
        """Return the file that this was read from."""
        return self._file

    @property
    def sha256(self) -> str:
        """Return the hash of the text, by which a pre-registration is known."""
        return hashlib.sha256(self._text.encode()).hexdigest()

    def fault(self, message: str, *path: str | int) -> InputError:
        """Return the error of a key that does not fit the data, with the place of the key."""
        if not self._text:
            return InputError(message)
        line, column = locate(self._text).of(path)
        return InputError(message, file=self._file, line=line, column=column)
