"""Orders of trials: rules, sequences, groups, and parts of a study."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from vrcomfort.settings import Name, Settings, Word

Rule = Literal[
    "explicit", "latin_square", "williams", "all_orders", "block_random", "random", "parts"
]

_FORMER_RULES = {"full": "all_orders"}
"""Words of the first version, which protocols of recorded studies have."""

NO_TASK = "none"
"""Says that nothing is done, where something else would be."""

Limit = Annotated[int, Field(ge=1, le=100)]
Share = Annotated[int, Field(ge=1, le=100)]


class Trial(Settings):
    """One exposure: a scene seen under a condition."""

    scene: str
    """One of the `scenes`."""
    condition: str
    """Name of a condition."""
    task: Word | None = None
    """Name of the task meanwhile; `none` for no task, even where the condition names one."""
    part: Word | None = None
    """Part of the study that it belongs to: the column `part`. [[parts]] set it themselves."""


class Sequence(Settings):
    """The order in which one participant meets the trials, session by session."""

    name: Name
    """As participants.csv has it."""
    group: Name | None = None
    """Whose order it is, where the protocol has [[groups]]."""
    sessions: Annotated[tuple[tuple[Trial, ...], ...], Field(min_length=1)]
    """A list for each session, of its trials in order."""

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Return all trials in order, sessions joined."""
        return tuple(trial for session in self.sessions for trial in session)


class Order(Settings):
    """How trials are ordered over participants.

    `explicit` takes the listed sequences; the other rules order every condition in every scene:
    `latin_square` (each at each position), `williams` (and each after each other equally often),
    `all_orders` (every order once), `block_random` (a seeded order of each participant's own, in
    blocks) and `random` (the same, one block without limits). `parts` has an order for each of
    [[parts]].
    """

    rule: Rule
    """How sequences are made."""
    sessions: Annotated[int, Field(ge=1, le=1000)] = 1
    """Sessions over which the generated rules deal the trials; explicit sequences say it."""
    unbalanced: bool = False
    """Whether orders may be unbalanced: sessions differ by an exposure where these do not divide
    evenly, and `check` takes any number of participants. Reports say so."""
    assignment: Literal["in_turn", "shuffled"] = "in_turn"
    """Among equally filled sequences take the first, or one drawn with the study's seed."""
    return_places: bool = True
    """Whether the place of a withdrawn or excluded participant, in a sequence and in a group, goes
    to the next who is enrolled."""
    blocks: Annotated[int, Field(ge=1, le=100)] = 1
    """`block_random`: each block has every condition in every scene once."""
    strata: Word | None = None
    """`block_random`: `condition`, `scene` or a factor; a block comes in rounds of one trial of
    each of its levels, so that these are spread evenly."""
    max_run: dict[str, Limit] = Field(default_factory=dict)
    """`block_random`: how many trials in a row may have the same `condition`, `scene`, level of a
    factor, or `trial` (condition and scene; 1 without it). `{ scene = 1 }`: none twice in a row."""
    sequences: tuple[Sequence, ...] = ()
    """Those of `explicit`."""

    @field_validator("rule", mode="before")
    @classmethod
    def _name_former_rules(cls, value: Any) -> Any:
        return _FORMER_RULES.get(value, value) if isinstance(value, str) else value


class Covariate(Settings):
    """A fact on a participant that is entered at the enrolment, before the first session."""

    name: Word
    """Column of participants.csv."""
    levels: tuple[Name, ...] = ()
    """Possible values; without them, it is a number."""
    low: Annotated[float, Field(ge=-1e6, le=1e6)] = 0.0
    """The least number that is taken for possible."""
    high: Annotated[float, Field(ge=-1e6, le=1e6)] = 120.0
    """The numbers that are taken for possible."""
    cuts: tuple[Annotated[float, Field(ge=-1e6, le=1e6)], ...] = ()
    """Where a number's bands begin: `[30, 50]` makes below 30, 30 to below 50, and 50 and more."""

    @field_validator("cuts")
    @classmethod
    def _rising(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if any(after <= before for before, after in pairwise(value)):
            raise PydanticCustomError("cuts", "must rise: the lowest first")
        return value

    @property
    def bands(self) -> tuple[str, ...]:
        """Return the strata of allocation: the levels, or the bands of a number."""
        if self.levels:
            return self.levels
        edges = [f"{cut:g}" for cut in self.cuts]
        if not edges:
            return ("any",)
        between = [f"{a} to <{b}" for a, b in pairwise(edges)]
        return (f"<{edges[0]}", *between, f"{edges[-1]}+")

    def band(self, value: str) -> str:
        """Return the level or band of a value that `fault` finds nothing wrong with."""
        if self.levels:
            return value
        return self.bands[sum(float(value) >= cut for cut in self.cuts)]

    def fault(self, value: str) -> str | None:
        """Return a sentence on the allowed values for a value that is not among them."""
        if self.levels:
            return None if value in self.levels else f"must be one of {', '.join(self.levels)}"
        try:
            # `float` takes the digits of every script, which a report would not read.
            possible = value.isascii() and self.low <= float(value) <= self.high
        except ValueError:
            possible = False
        return None if possible else f"must be a number from {self.low:g} to {self.high:g}"


class Group(Settings):
    """A level of the between-subject factor, with the conditions of its participants."""

    name: Name
    """As participants.csv has it."""
    label: str = ""
    """In words."""
    conditions: tuple[str, ...] = ()
    """Names of conditions; without it, all. Explicit sequences name their group instead."""
    share: Share = 1
    """How many of a block are in this group: 2 and 1 give two thirds and one third."""


class Allocation(Settings):
    """How participants are divided among the groups.

    `permuted_blocks`: random order in blocks of fixed shares, a list of its own for each stratum.
    `minimisation` (Pocock & Simon 1975): the group that makes the margins of the covariates most
    alike, with probability `p_best`. `simple`: drawn anew for each, for comparison.
    """

    method: Literal["permuted_blocks", "minimisation", "simple"] = "permuted_blocks"
    """Method by which participants come into groups."""
    rounds: Annotated[tuple[Limit, ...], Field(min_length=1, max_length=9)] = (2,)
    """`permuted_blocks`: block size, in multiples of the allocation ratio. Of several numbers one
    is drawn for each block, so that its end cannot be guessed."""
    by: tuple[str, ...] = ()
    """Covariates: strata of `permuted_blocks`, margins of `minimisation`."""
    p_best: Annotated[float, Field(ge=0.5, le=1)] = 0.9
    """`minimisation`: chance of the best group; at 1 the next allocation can be foretold."""


class PartOrder(Settings):
    """One order of the trials of a part."""

    name: Name
    """Within the part; names of sequences are put together from these."""
    group: Name | None = None
    """Group that has this order, where the protocol has [[groups]]; without it, every group."""
    trials: Annotated[tuple[Trial, ...], Field(min_length=1)]
    """Trials, in this order."""


class Part(Settings):
    """Trials that belong together, for `[order] rule = "parts"`.

    Everybody meets each part in one of its orders, dealt evenly and without regard to those of the
    other parts.
    """

    name: Word
    """In the column `part` of files and reports."""
    session: Annotated[int, Field(ge=1, le=1000)] = 1
    """Number of the session that it is in; parts of one session follow each other as written."""
    rule: Literal["explicit", "latin_square", "williams", "all_orders"] = "explicit"
    """How its orders are made; see [order]."""
    conditions: tuple[str, ...] = ()
    """Of orders that a rule makes; without it, all."""
    scenes: tuple[str, ...] = ()
    """The same."""
    orders: tuple[PartOrder, ...] = ()
    """Those of `explicit`."""
    repeats: Annotated[int, Field(ge=1, le=100)] = 1
    """Repetitions of an order, one after the other."""


def orders_of(part: Part, group: str) -> tuple[PartOrder, ...]:
    """Return the written orders that a group meets; `group` is blank without groups."""
    return tuple(order for order in part.orders if not group or order.group in (None, group))


def written_orders(parts: tuple[Part, ...]) -> Iterator[tuple[int, int, PartOrder]]:
    """Yield the indices of part and order, and the order, of all that are written down."""
    for index, part in enumerate(parts):
        for number, order in enumerate(part.orders):
            yield index, number, order
