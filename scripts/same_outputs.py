#!/usr/bin/env python3
"""Shows that a change of the code changes no output: the same bytes as those of another revision.

Runs the shipped protocols (simulated sessions with their reports, plans, designs, pictures of every
condition, played traces, imports of the tests' layouts) with the code of a revision and with that
of the working tree, and compares every file. Differences by nature are left out: clock times,
timings, hashes of the code, and columns that only the newer code writes. Exit code 1 where
anything else differs.

    .venv/bin/python scripts/same_outputs.py 05fae2d --out out/same
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TIMES = re.compile(r"_ms$|^asked_s$|^answered_s$|^latency_s$|^enrolled_at$")
BY_NATURE = {
    "started_at", "finished_at", "exposure_ended", "version", "versions", "shaders", "machine",
    "python", "platform", "imported_at", "vrcomfort",
    "under_way", "git", "schema", "schema_version", "source", "date", "path", "study",
}  # fmt: skip
PROGRESS = re.compile(r"^.* \.\.\.\n", re.MULTILINE)
MAPPING = "map.toml"
POSES = {
    "temple": ("-1,1.6,-4.3,47,-4,0", "-1.03,1.6,-4.3,44,-4,0"),
    "mountain": ("1.2,1.5,-1.9,-32,-8,0", "1.25,1.5,-1.9,-30,-8,0"),
}


def protocols() -> dict[str, list[str]]:
    """Return the shipped protocols and the names of their conditions."""
    texts = {path.stem: path.read_text() for path in sorted((ROOT / "protocols").glob("*.toml"))}
    return {
        name: [each["name"] for each in tomllib.loads(text).get("conditions", [])]
        for name, text in texts.items()
    }


def commands(inputs: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the name of an output and the command that makes it."""
    for folder in sorted(inputs.iterdir()):
        name, files = f"imports/{folder.name}", sorted(map(str, folder.iterdir()))
        yield f"{name}/mapping", ["import", *files, "--suggest", "--out", f"@{name}/{MAPPING}"]
        made = ["--mapping", f"@{name}/{MAPPING}", "--out", f"@{name}/study"]
        yield f"{name}/study", ["import", *files, *made]
    small, few = ["--size", "160x200"], ["--exposure-s", "0.1", "--refresh-hz", "40"]
    gaze = {"mantiuk_2011"}
    for protocol, conditions in protocols().items():
        yield f"{protocol}/passes", ["passes", protocol, *small]
        yield f"{protocol}/design", ["design", protocol, "--participants", "8"]
        if protocol not in gaze:
            people = "6" if protocol in {"smoke", "carnegie_2015"} else "2"
            study = f"{protocol}/study"
            yield study, ["simulate", protocol, "-n", people, *small, *few, "--out", "@" + study]
            yield f"{protocol}/report", ["report", "@" + study, "--out", f"@{protocol}/report"]
        for condition in conditions:
            for scene, (pose, previous) in POSES.items():
                out = f"{protocol}/{condition}_{scene}"
                yield (
                    out,
                    ["render", "--scene", scene, f"--pose={pose}", f"--previous-pose={previous}",
                     "--protocol", protocol, "--condition", condition, *small, "--out", "@" + out],
                )  # fmt: skip
    for scene in POSES:
        out = f"play/{scene}"
        trace = str(ROOT / "scenes" / f"{scene}_walk.csv")
        yield out, ["play", trace, "--scene", scene, "--frames", "12", *small, "--out", "@" + out]


def write_layouts(folder: Path) -> None:
    """Write the other labs' files of the tests, each layout in a folder of its own."""
    sys.path.insert(0, str(ROOT))
    from tests.support.layouts import LAYOUTS  # noqa: PLC0415 - found through the line above
    from tests.support.odd_layouts import ODD_LAYOUTS  # noqa: PLC0415

    shutil.rmtree(folder, ignore_errors=True)
    for name, write in {**LAYOUTS, **ODD_LAYOUTS}.items():
        (folder / name).mkdir(parents=True)
        write(folder / name)


def answer_doubts(mapping: Path) -> None:
    """Answer every doubt of a suggested mapping, so that it can be used."""
    if mapping.is_file():
        text = mapping.read_text(encoding="utf-8")
        mapping.write_text(text.replace('answer = ""', 'answer = "yes"'), encoding="utf-8")


def run(checkout: Path, out: Path, only: str) -> None:
    """Run commands with the code of a checkout; keep their prints, too."""
    shutil.rmtree(out, ignore_errors=True)
    inputs = out.parent / "inputs"  # the same for both: workbooks have the time in them
    environment = {**os.environ, "PYTHONPATH": str(checkout), "COLUMNS": "100"}
    program = "import sys; from vrcomfort.cli import main; sys.argv[0] = 'vrcomfort'; main()"
    for name, words in commands(inputs):
        if not name.startswith(only):
            continue
        log = out / f"{name}.txt"
        log.parent.mkdir(parents=True, exist_ok=True)
        words_here = [re.sub("^@", f"{out}/", word) for word in words]
        ended = subprocess.run(
            [sys.executable, "-c", program, *words_here],
            env=environment, cwd=out, capture_output=True, text=True, check=False,
        )  # fmt: skip
        told = PROGRESS.sub("", ended.stderr)  # a faster run, or a free machine, says it less often
        said = (ended.stdout + told).replace(str(out), "OUT").replace(str(checkout), "")
        log.write_text(re.sub(r"\s+", " ", f"{said}\nexit code {ended.returncode}\n"))
        answer_doubts(out / Path(name).parent / MAPPING)
        print(f"{name}: exit code {ended.returncode}", flush=True)


def comparable(file: Path, columns: set[str] | None) -> object:
    """Return what of a file must be the same; columns: those that both versions write."""
    # Checksums are of files with clock times in them; `verify` holds those against their files.
    if file.name in {"timing.csv", "checksums.sha256"} or file.suffix == ".lock":
        return None
    if file.suffix == ".csv" and columns is not None:
        rows = csv.DictReader(io.StringIO(file.read_text()))
        return [{k: v for k, v in row.items() if k in columns} for row in rows]
    if file.suffix == ".json":
        return without(json.loads(file.read_text()))
    if file.suffix in {".html", ".txt", ".md"}:
        text = re.sub(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d)?", "TIME", file.read_text())
        return text.replace(str(file.parents[len(file.parts) - 2]), "")
    return file.read_bytes()


def without(value: object) -> object:
    """Leave out of a JSON value what differs by nature."""
    if isinstance(value, dict):
        return {k: without(v) for k, v in value.items() if k not in BY_NATURE}
    return [without(each) for each in value] if isinstance(value, list) else value


def header(file: Path) -> set[str]:
    """Return the columns of a CSV file that say the same in every run."""
    with file.open() as lines:
        return {name for name in next(csv.reader(lines), []) if not TIMES.search(name)}


def differences(before: Path, after: Path) -> Iterator[str]:
    """Yield a line for each file that is missing, new or different."""
    files = {
        folder: {p.relative_to(folder) for p in folder.rglob("*") if p.is_file()}
        for folder in (before, after)
    }
    for name in sorted(files[before] | files[after]):
        if name not in files[after]:
            yield f"missing: {name}"
        elif name not in files[before]:
            yield f"new: {name}"
        else:
            a, b = before / name, after / name
            both = header(a) & header(b) if name.suffix == ".csv" else None
            if comparable(a, both) != comparable(b, both):
                yield f"differs: {name}"


def main() -> int:
    """Compare the working tree with a revision."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("revision", help="for example HEAD~1")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "same")
    parser.add_argument("--only", default="", help="outputs whose names begin so, such as smoke/")
    parser.add_argument("--keep", action="store_true", help="use outputs of REVISION made before")
    parser.add_argument("--only-before", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    out = options.out.resolve()
    before, checkout = out / "before", out / "checkout"
    if not (options.keep and before.is_dir()):
        write_layouts(out / "inputs")
        subprocess.run(["git", "worktree", "prune"], cwd=ROOT, check=True)
        shutil.rmtree(checkout, ignore_errors=True)
        subprocess.run(
            ["git", "worktree", "add", "--force", "--detach", str(checkout), options.revision],
            cwd=ROOT, check=True,
        )  # fmt: skip
        run(checkout, before, options.only)
        subprocess.run(
            ["git", "worktree", "remove", "--force", str(checkout)], cwd=ROOT, check=True
        )
    if options.only_before:
        return 0
    run(ROOT, out / "after", options.only)
    found = list(differences(before, out / "after"))
    total = sum(1 for p in before.rglob("*") if p.is_file())
    print("\n".join(found))
    print(f"{total} files compared with {options.revision}: {len(found)} differ")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
