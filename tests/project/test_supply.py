"""What is installed is what requirements.lock names: versions, hashes, licences, size."""

from __future__ import annotations

import csv
import http.server
import json
import os
import re
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import Distribution, PackageNotFoundError, distribution, version
from itertools import chain
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from scripts import licences
from tests.support.places import ROOT

LOCK = ROOT / "requirements.lock"
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT = PYPROJECT["project"]
ENTRY = re.compile(
    r"(?P<requirement>[^\\\n]+?)(?P<hashes>(?: \\\n    --hash=sha256:[0-9a-f]{64})+)\n"
)


def locked() -> dict[str, Requirement]:
    found = [Requirement(each["requirement"]) for each in ENTRY.finditer(LOCK.read_text("utf-8"))]
    return {canonicalize_name(each.name): each for each in found}


def pinned(requirement: Requirement) -> str:
    (only,) = requirement.specifier
    assert only.operator == "=="
    return only.version


def declared() -> list[Requirement]:
    extras = chain.from_iterable(PROJECT["optional-dependencies"].values())
    texts = [*PROJECT["dependencies"], *PYPROJECT["build-system"]["requires"], *extras]
    return [each for each in map(Requirement, texts) if each.name != PROJECT["name"]]


def applies(requirement: Requirement) -> bool:
    return requirement.marker is None or requirement.marker.evaluate()


def needed_by(requirements: list[Requirement]) -> dict[str, Distribution]:
    """Return these packages and all that they need here."""
    found: dict[str, Distribution] = {}
    waiting = [(each, "") for each in requirements]
    while waiting:
        requirement, extra = waiting.pop()
        name = canonicalize_name(requirement.name)
        marker = requirement.marker
        if name in found or (marker is not None and not marker.evaluate({"extra": extra})):
            continue
        found[name] = distribution(name)
        extras = requirement.extras or {""}
        texts = found[name].requires or ()
        waiting += [(Requirement(text), each) for text in texts for each in extras]
    return found


def megabytes(distributions: Iterator[Distribution] | list[Distribution]) -> float:
    """Return the size of all files, those that Python has compiled among them."""
    files = {file for each in distributions for file in files_of(each)}
    folders = {folder for file in files for folder in (parent(file), f"{parent(file)}/__pycache__")}
    sizes = {path: size for each in folders for path, size in sizes_in(each).items()}
    compiled = {each for each in sizes if each.endswith(".pyc") and source(each) in files}
    return sum(sizes[each] for each in sizes.keys() & (files | compiled)) / 1e6


def files_of(installed: Distribution) -> Iterator[str]:
    """Yield the paths of a package's files, without an object for each, of which there are many."""
    root = str(installed.locate_file(""))
    for name, *_ in csv.reader((installed.read_text("RECORD") or "").splitlines()):
        yield f"{root}/{name}"


def source(compiled: str) -> str:
    """Return the file that was compiled, by Python or by pytest, which adds its version."""
    folder, _, name = compiled.rpartition("/__pycache__/")
    return f"{folder}/{name.partition('.')[0]}.py"


def parent(file: str) -> str:
    return file.rpartition("/")[0]


@cache
def sizes_in(folder: str) -> dict[str, int]:
    """Return the sizes of the files of a folder, which need not be there."""
    try:
        with os.scandir(folder) as found:
            return {entry.path: entry.stat().st_size for entry in found if entry.is_file()}
    except FileNotFoundError:
        return {}


@pytest.mark.smoke
def test_the_lock_has_versions_and_hashes_and_no_place_to_get_them_from():
    text = LOCK.read_text("utf-8")
    comment, rest = text.split("\n", 1)
    assert comment.startswith("# Made by scripts/lock.sh")
    assert ENTRY.sub("", rest) == ""
    assert len(locked()) == len(re.findall(r"^\S", rest, re.MULTILINE))
    assert "://" not in text


@pytest.mark.smoke
def test_the_lock_has_what_the_project_declares():
    pins = locked()
    for each in declared():
        pin = pins[canonicalize_name(each.name)]
        assert each.specifier.contains(pinned(pin)), each
        if applies(each):
            assert applies(pin), each


@pytest.mark.smoke
def test_what_is_installed_is_what_the_lock_has():
    pins = {name: pinned(each) for name, each in locked().items() if applies(each)}
    assert {name: version(name) for name in pins} == pins
    assert set(needed_by(declared())) == set(pins), "all that is needed, and nothing else"


def test_every_way_to_install_takes_dependencies_by_hash_and_the_project_without_any():
    setup, runtime, bare = (
        (ROOT / "scripts" / name).read_text("utf-8")
        for name in ("setup.sh", "in_runtime.sh", "bare.sh")
    )
    assert "--require-hashes --requirement requirements.lock" in setup
    assert "--no-index --no-deps --no-build-isolation --editable ." in setup
    assert '--require-hashes --requirement "$checkout/requirements.lock"' in runtime
    assert "scripts/setup.sh --tests" in bare
    for script in (setup, runtime, bare):
        assert "--constraint" not in script


# Licences.


def test_the_page_of_licences_is_of_the_lock():
    written = licences.PAGE.read_text("utf-8")
    assert written == licences.page(), "run python scripts/licences.py"


@pytest.mark.parametrize(
    ("stated", "refused"),
    [
        ("License-Expression: MIT", None),
        ("License-Expression: LicenseRef-Proprietary OR MIT", None),
        ("License-Expression: MIT AND GPL-2.0-only", "ours (MIT AND GPL-2.0-only)"),
        ("License-Expression: (MIT AND SSPL-1.0) OR SSPL-1.0", "ours ((MIT"),
        ("License: Proprietary", "ours (unknown)"),
        ("Classifier: License :: Other/Proprietary License", "ours (unknown)"),
        ("Summary: says nothing", "ours (unknown)"),
        ("License: MIT", None),
        ("Classifier: License :: OSI Approved :: ISC License (ISCL)", None),
    ],
)
def test_a_package_of_another_licence_is_refused(tmp_path, monkeypatch, stated, refused):
    folder = tmp_path / "ours-1.0.dist-info"
    folder.mkdir()
    facts = f"Metadata-Version: 2.4\nName: ours\nVersion: 1.0\n{stated}\n"
    (folder / "METADATA").write_text(facts, encoding="utf-8")
    lock = tmp_path / "requirements.lock"
    lock.write_text("ours==1.0 \\\n    --hash=sha256:0\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    if refused is None:
        assert "| ours | " in licences.page(lock)
    else:
        with pytest.raises(ValueError, match=re.escape(refused)):
            licences.page(lock)


def test_licences_told_for_other_systems_are_those_of_the_packages():
    here = 0
    for name, told in licences.ELSEWHERE.items():
        try:
            version(name)
        except PackageNotFoundError:
            continue
        here += 1
        assert licences.licence(name) == told
    assert here
    assert set(licences.ELSEWHERE) <= set(locked())


# The audit.


@contextmanager
def database(answer: bytes, status: int = 200) -> Iterator[tuple[str, list[dict[str, object]]]]:
    """Answer as OSV does, and keep what was asked."""
    asked: list[dict[str, object]] = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            asked.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(status)
            self.end_headers()
            self.wfile.write(answer)

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/v1/querybatch", asked
        finally:
            server.shutdown()
            thread.join()


def audit(address: str, lock: Path) -> subprocess.CompletedProcess[str]:
    direct = {"NO_PROXY": "127.0.0.1", "no_proxy": "127.0.0.1", "VRCOMFORT_OSV": address}
    return subprocess.run(
        [sys.executable, str(ROOT / "scripts/audit.py"), str(lock)],
        env={**os.environ, **direct},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def two_packages(tmp_path) -> Path:
    lock = tmp_path / "requirements.lock"
    hashes = " \\\n    --hash=sha256:0\n"
    lock.write_text(f"one==1.0{hashes}two==2.0 ; os_name == 'nt'{hashes}", encoding="utf-8")
    return lock


def test_the_audit_asks_once_for_every_package_and_fails_for_one_with_a_vulnerability(two_packages):
    answer = {"results": [{}, {"vulns": [{"id": "PYSEC-2026-1", "modified": "2026-01-01"}]}]}
    with database(json.dumps(answer).encode()) as (address, asked):
        run = audit(address, two_packages)
    assert run.returncode == 1, run.stderr
    assert run.stdout.splitlines() == [
        "two 2.0: PYSEC-2026-1",
        "audited: 2 packages, 1 with known vulnerabilities",
    ]
    assert asked == [
        {
            "queries": [
                {"package": {"name": "one", "ecosystem": "PyPI"}, "version": "1.0"},
                {"package": {"name": "two", "ecosystem": "PyPI"}, "version": "2.0"},
            ]
        }
    ]


def test_the_audit_finds_nothing_where_there_is_nothing(two_packages):
    with database(b'{"results": [{}, {}]}') as (address, _):
        run = audit(address, two_packages)
    assert run.returncode == 0, run.stderr
    assert run.stdout == "audited: 2 packages, 0 with known vulnerabilities\n"


@pytest.mark.parametrize(
    ("answer", "status"),
    [(b"", 503), (b"<html>log in first</html>", 200), (b'{"results": [{}]}', 200), (b"[]", 200)],
)
def test_the_audit_says_that_there_was_none(two_packages, answer, status):
    with database(answer, status) as (address, _):
        run = audit(address, two_packages)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("NOT AUDITED: 2 packages; ")


def test_without_a_database_there_is_no_audit(two_packages):
    with database(b"") as (address, _):
        pass
    closed = audit(address, two_packages)
    assert closed.returncode == 0
    assert closed.stdout.startswith("NOT AUDITED: 2 packages; ")


# Size.


def test_set_up_says_how_large_it_is():
    said = re.search(r"about ([\d.]+) GB", (ROOT / "scripts/setup.sh").read_text("utf-8"))
    assert said
    own = [distribution(name) for name, pin in locked().items() if applies(pin)]
    assert megabytes(own) / 1000 == pytest.approx(float(said[1]), rel=0.15)


def test_a_plain_installation_is_small():
    """Without extras: vrcomfort and what it needs, as `pip install` puts it on the disk."""
    needed = needed_by([Requirement(each) for each in PROJECT["dependencies"]])
    assert "scipy" in needed
    assert "av" not in needed, "videos are an extra"
    shipped = PYPROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    own = sum(
        file.stat().st_size
        for folder in ("vrcomfort", *shipped)
        for file in (ROOT / folder).rglob("*")
        if file.is_file()
    )
    assert megabytes(list(needed.values())) + own / 1e6 <= 900
