"""Looks through the XML of an archive before anything is built of it."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from vrcomfort.errors import InputError

MOST_BYTES = 2**28
"""Of XML, unpacked: some five million cells."""
MOST_ELEMENTS = 30_000_000
"""Of XML: a cell is two or three."""
NO_WORKBOOK = "this is not a workbook that can be read; save it as .xlsx or CSV"
_CONTENTS = "[Content_Types].xml"
_LOOKED_AT = 64
"""Bytes of a file in which XML has its first sign."""
_SAVE_AGAIN = "open it in a spreadsheet program, and save it again"
_DAMAGED = (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError)
"""What zipfile raises on damaged archives, on a password, and on compression it does not know."""


def check_archive(content: bytes, file: Path) -> None:
    """See that the XML of an archive is whole, and no more than can be read.

    Document types are refused: nothing that a spreadsheet program saves has one, and entities
    expand.

    Raises
    ------
    InputError
        With the part of the archive, and the line and column in it.
    """
    elements = 0

    def count(_name: str, _attributes: object) -> None:
        nonlocal elements
        elements += 1
        if elements > MOST_ELEMENTS:
            _refuse(file, f"it holds more than {MOST_ELEMENTS:,} elements; delete what is no data")

    def no_document_type(*_: object) -> None:
        _refuse(file, f"{part} has a document type, as no workbook has; {_SAVE_AGAIN}")

    part = ""
    if not zipfile.is_zipfile(io.BytesIO(content)):
        raise InputError(NO_WORKBOOK, file=file)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if _CONTENTS not in archive.namelist():
                raise InputError(NO_WORKBOOK, file=file)
            parts = [each for each in archive.infolist() if _is_xml(archive, each)]
            unpacked = sum(each.file_size for each in parts)
            if unpacked > MOST_BYTES:
                most = f"{MOST_BYTES >> 20} MB; delete what is no data"
                _refuse(file, f"it unpacks to {unpacked >> 20:,} MB, and may to {most}")
            for each in parts:
                part = each.filename
                parser = expat.ParserCreate()
                parser.StartDoctypeDeclHandler = no_document_type
                parser.StartElementHandler = count
                with archive.open(each) as stream:
                    parser.ParseFile(stream)
    except expat.ExpatError as error:
        place = f"{part}, line {error.lineno}, column {error.offset + 1}"
        what = expat.ErrorString(error.code)
        _refuse(file, f"it is damaged ({place}: {what}); {_SAVE_AGAIN}")
    except _DAMAGED as error:
        said = " ".join(str(error).split())[:80]
        _refuse(file, f"it is damaged ({part or 'the archive'}: {said}); {_SAVE_AGAIN}")


def _is_xml(archive: zipfile.ZipFile, part: zipfile.ZipInfo) -> bool:
    with archive.open(part) as stream:
        return b"<" in stream.read(_LOOKED_AT)


def _refuse(file: Path, why: str) -> NoReturn:
    raise InputError(f"this workbook cannot be read: {why}", file=file)
