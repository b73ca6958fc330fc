"""Reads the sheets of Excel workbooks as text."""

from __future__ import annotations

import warnings
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.errors import InputError
from vrcomfort.importing.source import Grid, Reading, cell_text
from vrcomfort.importing.text_files import read_bytes

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet


def read_workbook(file: Path, reading: Reading) -> list[Grid]:
    """Read every sheet that holds anything; a merged cell's text stands in all of its cells.

    Formulas are their values when the workbook was last saved.

    Raises
    ------
    InputError
        If it is no workbook, or a formula has no saved value, with sheet and cell.
    """
    from openpyxl import load_workbook  # noqa: PLC0415 - slow, and for workbooks alone
    from openpyxl.utils.exceptions import InvalidFileException  # noqa: PLC0415

    read_bytes(file)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # styles and such that it does not keep
            book = load_workbook(file, data_only=True)
            formulas = load_workbook(file)
    except (InvalidFileException, zipfile.BadZipFile, KeyError, ValueError, OSError):
        message = "this is not a workbook that can be read; save it as .xlsx or CSV"
        raise InputError(message, file=file) from None
    sheets = [book[name] for name in book.sheetnames if hasattr(book[name], "iter_rows")]
    grids = [_grid(file, sheet, formulas[sheet.title], reading) for sheet in sheets]
    found = [grid for grid in grids if grid.rows]
    if not found:
        raise InputError("this workbook is empty", file=file)
    return found


def _grid(file: Path, sheet: Worksheet, formulas: Worksheet, reading: Reading) -> Grid:
    cells = [[cell_text(cell.value) for cell in row] for row in sheet.iter_rows()]
    _require_saved_values(file, sheet, formulas)
    for merged in sheet.merged_cells.ranges:
        text = cells[merged.min_row - 1][merged.min_col - 1]
        for row in range(merged.min_row, merged.max_row + 1):
            for column in range(merged.min_col, merged.max_col + 1):
                cells[row - 1][column - 1] = text
    kept = [(number, row) for number, row in enumerate(cells, start=1) if any(row)]
    hidden = sheet.sheet_state != "visible"
    notes = (f"{file.name}: the sheet {sheet.title} is hidden, and was read",) if hidden else ()
    found = reading._replace(decimal=reading.decimal or ".")
    return Grid(
        file,
        sheet.title,
        tuple(tuple(row) for _, row in kept),
        tuple(number for number, _ in kept),
        found,
        notes,
    )


def _require_saved_values(file: Path, sheet: Worksheet, formulas: Worksheet) -> None:
    for row in formulas.iter_rows():
        for cell in row:
            if cell.data_type == "f" and sheet[cell.coordinate].value is None:
                message = "this formula has no saved value; open the workbook, and save it again"
                place = f"sheet {sheet.title}, cell {cell.coordinate}"
                raise InputError(f"{file}, {place}: {message}")
