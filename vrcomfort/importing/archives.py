"""Checks the XML of a workbook's archive before it is parsed into objects."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from xml.parsers import expat

from vrcomfort.errors import InputError

MOST_BYTES = 2**28
"""Of XML, unpacked: some five million cells."""
MOST_ELEMENTS = 30_000_000
"""Of XML: a cell is two or three."""

_LOOKED_AT = 64
"""Bytes of a file in which XML has its first sign."""
_SAVE_AGAIN = "open it in a spreadsheet program, and save it again"
_NO_WORKBOOK = "this is not a workbook that can be read; save it as .xlsx or CSV"


def check_archive(content: bytes, file: Path) -> None:
    """Check that the XML of a workbook is well-formed and within the limits.

    Document types are refused: no spreadsheet program writes one, and their entities expand.

    Raises
    ------
    InputError
        With the part of the archive, and the line and column in it.
    """
    with one_sentence(file, "this workbook"):
        archive = _opened(content, file)
        parts = [each for each in archive.infolist() if _is_xml(archive, each)]
        _require_room(sum(each.file_size for each in parts), MOST_BYTES, "bytes", file)
    elements = 0

    def count(_name: str, _attributes: object) -> None:
        nonlocal elements
        elements += 1
        _require_room(elements, MOST_ELEMENTS, "elements", file)

    for part in parts:
        name = f"{part.filename} of this workbook"
        with one_sentence(file, name), archive.open(part) as stream:
            parser = expat.ParserCreate()
            parser.StartDoctypeDeclHandler = partial(_refuse_document_type, file, name)
            parser.StartElementHandler = count
            parser.ParseFile(stream)


@contextmanager
def one_sentence(file: Path, what: str) -> Iterator[None]:
    """Turn any exception while `what` is read into one sentence.

    zipfile and openpyxl do not validate what they read: exceptions of all types come from them.

    Raises
    ------
    InputError
        In place of any other exception.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:80]}"
        raise InputError(f"{what} is damaged ({said}); {_SAVE_AGAIN}", file=file) from error


def _refuse_document_type(file: Path, name: str, *_: object) -> None:
    message = f"{name} has a document type, as no spreadsheet program writes it"
    raise InputError(f"{message}; {_SAVE_AGAIN}", file=file)


def _opened(content: bytes, file: Path) -> zipfile.ZipFile:
    if zipfile.is_zipfile(io.BytesIO(content)):
        archive = zipfile.ZipFile(io.BytesIO(content))
        if "[Content_Types].xml" in archive.namelist():
            return archive
    raise InputError(_NO_WORKBOOK, file=file)


def _is_xml(archive: zipfile.ZipFile, part: zipfile.ZipInfo) -> bool:
    with archive.open(part) as stream:
        return b"<" in stream.read(_LOOKED_AT)


def _require_room(found: int, most: int, what: str, file: Path) -> None:
    if found > most:
        message = f"this workbook unpacks to more than {most:,} {what}; delete what is no data"
        raise InputError(message, file=file)
