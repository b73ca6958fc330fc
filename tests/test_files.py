"""Files are opened in one place, which takes regular files alone, of a size that memory holds."""

from __future__ import annotations

import ast
import os
import re
import sys
from collections import defaultdict
from pathlib import Path

import pytest

import vrcomfort
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.files import open_file, read_bytes, read_text, sha256_of
from vrcomfort.importing import load_mapping
from vrcomfort.importing.files import read_tables
from vrcomfort.importing.head_logs import suggest_log_mapping
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import read_instrument
from vrcomfort.records.disk import OWNER, open_new
from vrcomfort.report.plan_files import load_plan
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")

READS = {
    "open", "read_text", "read_bytes", "read_csv", "read_parquet", "read_excel", "read_json",
    "load", "loads", "loadtxt", "genfromtxt", "fromfile", "memmap", "ZipFile", "iterparse",
    "copyfile", "copy2", "copytree", "fdopen", "mmap", "fromstring",
}  # fmt: skip
"""Methods, and functions of modules, that read a file or parse what was read."""
NAMES = {"open", "iterparse", "load_workbook", "ZipFile"}
"""Those that are called by their name alone."""
MODULES = {
    "json", "tomllib", "np", "zipfile", "wave", "os", "io", "shutil", "duckdb", "Image", "pd",
}  # fmt: skip
"""Whose functions are told with the module's name: `json.loads`."""

ELSEWHERE: dict[str, tuple[set[str], str]] = {
    "files.py": ({"open", "os.open"}, "the one place"),
    "json_text.py": ({"json.loads"}, "the one place for JSON"),
    "settings/reading.py": ({"tomllib.loads"}, "the one place for TOML"),
    "importing/workbooks.py": (
        {"zipfile.ZipFile", ".open", "iterparse", "load_workbook"}, "workbooks, after their check"
    ),
    "records/recording.py": (
        {"duckdb.connect", "shutil.copyfile"}, "recordings, of which CsvTable has read the header"
    ),
    "records/disk.py": ({"os.open", "os.fdopen"}, "files to write"),
    "records/interrupted.py": ({".open", "os.fdopen", "shutil.copyfile"}, "mends what was read"),
    "records/json_file.py": ({"json.loads"}, "indents what this program has encoded"),
    "headset/sound.py": ({"os.open", "wave.open"}, "the null device; the bytes of a sound"),
    "headset/monado.py": ({".read_text"}, "the log of a service that this program started"),
    "scene/gltf/file.py": ({".open"}, "pictures, of the bytes that were read"),
    "respondent/panel_picture.py": ({"Image.open"}, "pictures, of an opened file"),
    "tradeoff/store.py": ({"np.load"}, "arrays, of an opened file"),
    "tradeoff/measure.py": ({"json.loads"}, "rows of the store"),
    "cli/app.py": ({"os.open"}, "the null device"),
    "console/server.py": ({"json.loads", "os.fdopen"}, "messages of the page, and pipes"),
    "console/wire.py": ({"json.loads"}, "messages between two processes of this program"),
    "render/output.py": ({".open"}, "a film to write"),
    "session/flow.py": ({".open"}, "a manifest and an operator's interface, which are no files"),
    "headset/openxr/graphics_binding.py": ({".load"}, "a function of a library"),
    "installed.py": ({".load"}, "the entry point of an installed package"),
}  # fmt: skip
"""Who reads otherwise, by which functions, and why that is safe."""
SHIPPED = {
    "cli/shipped.py", "gpu/shaders.py", "headset/eye_painter.py", "protocol/quality.py",
    "protocol/quality_levels.py",
    "report/references.py", "report/reproduce.py", "report/vocabulary.py", "text_layout.py",
}  # fmt: skip
"""Modules that read nothing but what is shipped with the package."""


CALLED = re.compile(rf"\b({'|'.join(sorted(READS | NAMES | {'connect'}))})\(")
"""Without one of these a module need not be parsed."""


def reads_of(text: str) -> set[str]:
    """Return the functions that a module reads files by."""
    found: set[str] = set()
    if not CALLED.search(text):
        return found
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.Call):
            continue
        function = node.func
        if isinstance(function, ast.Name) and function.id in NAMES:
            found.add(function.id)
        elif isinstance(function, ast.Attribute):
            owner = function.value.id if isinstance(function.value, ast.Name) else ""
            if function.attr not in READS and f"{owner}.{function.attr}" != "duckdb.connect":
                continue
            mode = node.args[0] if node.args else None
            writes = isinstance(mode, ast.Constant) and str(mode.value)[:1] in {"w", "x", "a"}
            if owner in MODULES or not (function.attr == "open" and writes):
                found.add(f"{owner}.{function.attr}" if owner in MODULES else f".{function.attr}")
    return found


def test_no_other_module_opens_or_parses_files():
    root = Path(vrcomfort.__file__).parent
    found = defaultdict(set)
    for file in root.rglob("*.py"):
        if reads := reads_of(file.read_text("utf-8")):
            found[file.relative_to(root).as_posix()] = reads
    assert {name: reads for name, reads in found.items() if name not in SHIPPED} == {
        name: reads for name, (reads, _) in ELSEWHERE.items()
    }


def test_what_is_looked_for_would_be_found():
    text = "a.open('rb'); open(b); x.open(); y.read_text(); json.loads(c); a.open('w')"
    assert reads_of(text) == {".open", "open", ".read_text", "json.loads"}


def pipe(file: Path) -> None:
    os.mkfifo(file)


def link_to_a_pipe(file: Path) -> None:
    os.mkfifo(file.with_name("pipe"))
    file.symlink_to(file.with_name("pipe"))


def link_to_a_device(file: Path) -> None:
    file.symlink_to("/dev/zero")


READERS = {
    "protocol.toml": load_protocol,
    "plan.toml": load_plan,
    "instrument.toml": read_instrument,
    "mapping.toml": load_mapping,
    "lab.xlsx": read_tables,
    "lab.json": read_tables,
    "lab.csv": read_tables,
    "trace.csv": read_trace,
    "log.csv": suggest_log_mapping,
    "table.csv": CsvTable.read,
    "scene.gltf": load_scene,
    "text": lambda file: read_text(file, "text"),
    "bytes": read_bytes,
    "hash": sha256_of,
    "to write": lambda file: open_new(file, OWNER, os.O_WRONLY | os.O_APPEND),
}


@posix
@pytest.mark.parametrize("make", [pipe, link_to_a_pipe, link_to_a_device])
@pytest.mark.parametrize("name", READERS)
def test_pipes_and_devices_are_refused_without_waiting(tmp_path, name, make):
    make(tmp_path / name)
    with pytest.raises(InputError, match=r"only files|symbolic link|there is no|is not a"):
        READERS[name](tmp_path / name)


def test_a_file_is_opened_as_it_is(tmp_path):
    file = tmp_path / "file"
    file.write_bytes(b"\xef\xbb\xbfa\r\nb\r")
    assert read_text(file, "text") == "a\nb\n"
    with open_file(file) as stream:
        assert stream.read() == file.read_bytes() == read_bytes(file, most=8)
    with pytest.raises(InputError, match="has 8 bytes, and at most 7 are read"):
        read_bytes(file, most=7)
    with pytest.raises(IsADirectoryError):
        open_file(tmp_path)
    with pytest.raises(FileNotFoundError):
        open_file(tmp_path / "none")
