"""Workbooks as spreadsheet programs save them, and as no program should."""

from __future__ import annotations

import datetime
import io
import zipfile
from collections.abc import Mapping

from openpyxl import Workbook

_XMLNS = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
SHEET = "xl/worksheets/sheet1.xml"


def good_workbook() -> bytes:
    """Return a workbook with what workbooks of labs have: merged cells, dates, two sheets."""
    book = Workbook()
    sheet = book.active
    sheet.title = "answers"
    rows = [
        ["code", "day", "before", None, "after", None],
        [None, None, "nausea", "fatigue", "nausea", "fatigue"],
        ["P01", datetime.date(2026, 3, 1), 0, 1.5, "none", True],
        ["P02", datetime.datetime(2026, 3, 2, 9, 30), 2, 0, "slight", False],
    ]  # fmt: skip
    for row in rows:
        sheet.append(row)
    for merged in ("A1:A2", "C1:D1", "E1:F1"):
        sheet.merge_cells(merged)
    other = book.create_sheet("more")
    other.append(["code", "age"])
    other.append(["P01", 31])
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()


def parts_of(content: bytes) -> dict[str, bytes]:
    """Return the parts of a workbook."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def archive_of(parts: Mapping[str, bytes]) -> bytes:
    """Return a workbook of parts."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return file.getvalue()


def with_sheet(rows: str, after: str = "", before: str = "") -> bytes:
    """Return a workbook whose first sheet has these rows of XML, and this before and after them."""
    xml = f"<worksheet {_XMLNS}>{before}<sheetData>{rows}</sheetData>{after}</worksheet>"
    return archive_of({**parts_of(good_workbook()), SHEET: xml.encode()})
