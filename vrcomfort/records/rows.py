"""Rows of CSV files: their columns, declared beside the fields, and their text.

A row type is a dataclass. The annotation of a field declares its column, or several:

    latency_s: Annotated[float | None, Column("Time until the rating", blank="none came")]

Its type, default and place in the class are the column's type and default and the place in the
header. Readers, DuckDB types, `verify`, `anonymise`, exports and docs/data_dictionary.md derive
from this declaration (`vrcomfort.records.schema`).
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import attrgetter
from types import NoneType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    TypeAlias,
    get_args,
    get_origin,
    get_type_hints,
)

from vrcomfort.escaping import escape_unprintable

LONGEST_CELL = 120_000
"""Characters; `csv` reads cells of up to 131,072."""

Cell: TypeAlias = str | int | float | None
CellType: TypeAlias = type[str] | type[int] | type[float]

Trait: TypeAlias = Literal["motion", "gaze", "text", "date"]
"""What people can be recognised by: motion and gaze may be kept on request, the others never."""
Needs: TypeAlias = frozenset[Trait]

ALWAYS: Needs = frozenset()
MOTION: Needs = frozenset({"motion"})
GAZE: Needs = frozenset({"gaze"})
BOTH: Needs = frozenset({"motion", "gaze"})
TEXT: Needs = frozenset({"text"})
DATE: Needs = frozenset({"date"})

_UNITS = {
    "_percent": "%", "_deg": "deg", "_rad": "rad", "_ms": "ms", "_ns": "ns", "_mm": "mm",
    "_px": "px", "_s": "s", "_m": "m",
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column of a CSV file.

    Parameters
    ----------
    meaning
        One phrase, for a reader of the table.
    blank
        What a blank cell means; empty where no recorder leaves it blank.
    since
        The schema version that introduced it. Older studies are whole without it.
    needs
        The traits that a copy for others has to keep for it; it is blank otherwise.
    signed
        Whether numbers may be negative.
    channel
        Type of its channel in Motion-BIDS; empty where the export has none.
    name, of
        Of columns that are not a field of their own: else those of the field.
    cell
        Returns the cell of a row; without it the cell is the field's value.
    """

    meaning: str
    blank: str = ""
    since: int = 1
    needs: Needs = ALWAYS
    signed: bool = False
    channel: Literal["", "POS", "ORNT", "MISC"] = ""
    name: str = ""
    of: CellType | None = None
    cell: Callable[[Any], Cell] | None = None

    @cached_property
    def type(self) -> CellType:
        """Return the type of its cells."""
        return self.of or float

    @cached_property
    def unit(self) -> str:
        """Return the unit, which names of numbers end in; empty without one."""
        units = (unit for suffix, unit in _UNITS.items() if self.name.endswith(suffix))
        return "" if self.type is str else next(units, "")


@dataclass(frozen=True)
class ColumnGroup:
    """Several columns that are written together, such as those of a pose.

    Parameters
    ----------
    each
        With their names and types.
    cells
        Returns their cells of a row.
    """

    each: tuple[Column, ...]
    cells: Callable[[Any], Iterable[Cell]]


class Row:
    """A row of a CSV file; the annotations of a subclass (a dataclass) declare its columns."""

    FILE: ClassVar[str]
    NEEDS: ClassVar[Needs] = ALWAYS
    """The traits that a copy for others has to keep for the file; it is left out otherwise."""
    FURTHER: ClassVar[tuple[Column, ...]] = ()
    """ColumnGroup that follow in some studies."""

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        return _layout(cls).names

    def cells(self) -> list[Cell]:
        """Return the values in the order of the header; None is missing."""
        cells: list[Cell] = []
        for of in _layout(type(self)).cells:
            cells += of(self)
        return cells


@dataclass(frozen=True)
class _Layout:
    """A row type's declarations, collected once: they are asked for with every row."""

    columns: tuple[Column, ...]
    single: frozenset[str]
    names: tuple[str, ...]
    cells: tuple[Callable[[Any], Iterable[Cell]], ...]


_LAYOUTS: dict[type[Row], _Layout] = {}


def _layout(row_type: type[Row]) -> _Layout:
    if (known := _LAYOUTS.get(row_type)) is not None:
        return known
    declarations = list(_declarations(row_type))
    columns: list[Column] = []
    for each in declarations:
        columns += [each] if isinstance(each, Column) else each.each
    _LAYOUTS[row_type] = _Layout(
        tuple(columns),
        frozenset(each.name for each in declarations if isinstance(each, Column)),
        tuple(each.name for each in columns),
        tuple(_getters(declarations)),
    )
    return _LAYOUTS[row_type]


def declared(row_type: type[Row]) -> tuple[Column, ...]:
    """Return the columns of every file of a kind, in the order of the header."""
    return _layout(row_type).columns


def single(row_type: type[Row]) -> tuple[Column, ...]:
    """Return those of the columns that stand alone: not those of poses, angles and rays."""
    layout = _layout(row_type)
    return tuple(each for each in layout.columns if each.name in layout.single)


def _declarations(row_type: type[Row]) -> Iterator[Column | ColumnGroup]:
    for name, hint in get_type_hints(row_type, include_extras=True).items():
        if get_origin(hint) is not Annotated:
            continue
        of, *said = get_args(hint)
        for each in said:
            if isinstance(each, Column):
                named = replace(each, name=each.name or name)
                yield named if named.of else replace(named, of=_cell_type(of))
            elif isinstance(each, ColumnGroup):
                yield each


def _cell_type(hint: Any) -> CellType:
    """Return the type of a field's cells: True is written as 1."""
    of = next((each for each in get_args(hint) if each is not NoneType), hint)
    if of is bool:
        return int
    if of not in (str, int, float):
        raise TypeError(f"a column of {hint} needs the type of its cells")
    kind: CellType = of
    return kind


def _getters(
    declarations: Iterable[Column | ColumnGroup],
) -> Iterator[Callable[[Any], Iterable[Cell]]]:
    """Yield functions that return a row's cells: `attrgetter` takes a run of fields at once."""
    run: list[str] = []
    for each in declarations:
        if isinstance(each, ColumnGroup):
            written = each.cells
        elif each.cell is not None:
            written = partial(_one, each.cell)
        else:
            run.append(each.name)
            continue
        if run:
            yield _fields(run)
        run = []
        yield written
    if run:
        yield _fields(run)


def _fields(names: Sequence[str]) -> Callable[[Any], Iterable[Cell]]:
    if len(names) == 1:
        return partial(_one, attrgetter(names[0]))
    several: Callable[[Any], tuple[Cell, ...]] = attrgetter(*names)
    return several


def _one(cell: Callable[[Any], Cell], row: Any) -> Iterable[Cell]:
    return (cell(row),)


def cell_text(value: Cell) -> str:
    """Write a cell: blank for None and for numbers that are none, shortest exact text for floats.

    Line ends inside a text become spaces, so that a row is a line and a cut one is seen. Other
    unprintable characters are escaped, and texts are cut at `LONGEST_CELL`.
    """
    if isinstance(value, float):  # most are
        # NumPy's own repr names the type; most floats are plain, and need no conversion
        exact = value if type(value) is float else float(value)
        return repr(exact) if math.isfinite(exact) else ""
    if value is None:
        return ""
    if not isinstance(value, str):
        return str(int(value))
    text = escape_unprintable(" ".join(value.splitlines()))
    return text if len(text) <= LONGEST_CELL else f"{text[:LONGEST_CELL]}…"


def csv_line(cells: Iterable[Cell]) -> str:
    """Return one CSV line with its line end; cells are written by `cell_text`."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(map(cell_text, cells))
    return line.getvalue()
