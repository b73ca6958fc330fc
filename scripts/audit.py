"""Look up all packages of requirements.lock in the OSV database of known vulnerabilities.

One request tells it names and versions, nothing else. Exits with 1 if a package has a vulnerability
that ACCEPTED does not name; where no database answers, it says NOT AUDITED and exits with 0.
"""

from __future__ import annotations

import http.client
import json
import os
import re
import sys
import urllib.request
from pathlib import Path
from typing import Any
from urllib.error import HTTPError

LOCK = Path(__file__).parent.parent / "requirements.lock"
DATABASE = os.environ.get("VRCOMFORT_OSV", "https://api.osv.dev/v1/querybatch")
PATIENCE_S = 20.0

ACCEPTED: dict[str, str] = {}
"""Identifier of a vulnerability → why it does not touch us. Otherwise
`scripts/lock.sh --upgrade-package NAME` takes a version without it."""


def locked(lock: Path) -> list[tuple[str, str]]:
    """Return the names and versions in a lock."""
    return re.findall(r"^([\w.-]+)==(\S+)", lock.read_text("utf-8"), re.MULTILINE)


def vulnerabilities(packages: list[tuple[str, str]]) -> dict[str, list[str]]:
    """Return package → identifiers of its vulnerabilities, for those that have any.

    Raises
    ------
    OSError, http.client.HTTPException
        If no database answers.
    ValueError
        If something else answers.
    """
    queries = [
        {"package": {"name": name, "ecosystem": "PyPI"}, "version": version}
        for name, version in packages
    ]
    request = urllib.request.Request(  # noqa: S310 - the address is ours
        DATABASE,
        json.dumps({"queries": queries}).encode(),
        {"Content-Type": "application/json"},
    )
    with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:  # noqa: S310
        found = json.load(answer)
    results: Any = found.get("results") if isinstance(found, dict) else None
    if not isinstance(results, list) or len(results) != len(packages):
        raise ValueError("the answer is not OSV's")
    return {
        f"{name} {version}": [each["id"] for each in result["vulns"]]
        for (name, version), result in zip(packages, results, strict=True)
        if result.get("vulns")
    }


def main(lock: Path) -> int:
    """Print what was found, and return the exit code."""
    packages = locked(lock)
    try:
        found = vulnerabilities(packages)
    except (OSError, http.client.HTTPException, ValueError) as error:
        if isinstance(error, HTTPError):
            error.close()
        print(f"NOT AUDITED: {len(packages)} packages; {DATABASE} does not answer ({error})")
        return 0
    open_ones = {
        package: unknown
        for package, known in found.items()
        if (unknown := [each for each in known if each not in ACCEPTED])
    }
    for package, identifiers in open_ones.items():
        print(f"{package}: {', '.join(identifiers)}")
    accepted = sum(map(len, found.values())) - sum(map(len, open_ones.values()))
    print(
        f"audited: {len(packages)} packages, {len(open_ones)} with known vulnerabilities"
        + (f", {accepted} accepted (see ACCEPTED in {Path(__file__).name})" if accepted else "")
    )
    return 1 if open_ones else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else LOCK))
