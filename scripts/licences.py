"""Write docs/licences.md: the licence of each locked package, none that ours does not permit.

Exits with 1, and writes nothing, if a package has another licence or does not say which.
"""

from __future__ import annotations

import re
import sys
from importlib.metadata import PackageMetadata, PackageNotFoundError, metadata
from pathlib import Path

ROOT = Path(__file__).parent.parent
LOCK = ROOT / "requirements.lock"
PAGE = ROOT / "docs" / "licences.md"

PERMITTED = {
    "0BSD", "Apache-2.0", "BSD", "BSD-2-Clause", "BSD-3-Clause", "CC0-1.0", "GPL-3.0", "ISC", "MIT",
    "MIT-0", "MIT-CMU", "MPL-2.0", "PSF-2.0", "Zlib",
}  # fmt: skip
"""What may be part of a program under GPL-3.0-or-later. BSD is one of its forms, not said which."""

WORDS = {
    "2-clause BSD": "BSD-2-Clause",
    "Apache 2.0": "Apache-2.0",
    "Apache Software License": "Apache-2.0",
    "BSD 2-Clause License": "BSD-2-Clause",
    "BSD 3-Clause License": "BSD-3-Clause",
    "BSD License": "BSD",
    "ISC License": "ISC",
    "ISC License (ISCL)": "ISC",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
    "The MIT License (MIT)": "MIT",
}
"""How packages without an SPDX expression name their licence → its identifier."""

ELSEWHERE = {
    "flip-evaluator": "BSD",
    "importlib-metadata": "Apache-2.0",
    "lazy-importer": "Apache-2.0",
    "zipp": "MIT",
}
"""Licences of packages that not every Python and system needs."""

INTRODUCTION = """# Licences

vrcomfort is under the GPL, version 3 or later (`LICENSE`). It is installed with, or
developed with, the packages below: those of `requirements.lock`, with all extras and tools. Each
licence permits a package's use in a program under ours; a test fails for one that does not. `BSD`
is one of its forms where a package does not say which. The names are those of
[SPDX](https://spdx.org/licenses/). Wheels also carry libraries, whose licences lie in the
`.dist-info` folder beside the package: that of `av` (the extra `video`) has FFmpeg with x264, which
is under the GPL, version 2 or later. `scripts/licences.py` writes this page from the metadata of
what is installed.

| package | licence |
|---|---|
"""


def locked(lock: Path) -> list[str]:
    """Return the names of the packages in a lock."""
    return re.findall(r"^([\w.-]+)==", lock.read_text("utf-8"), re.MULTILINE)


def licence(package: str) -> str | None:
    """Return an SPDX expression, or None where a package does not say what we know."""
    try:
        facts = metadata(package)
    except PackageNotFoundError:
        return ELSEWHERE.get(package)
    if expression := facts.get("License-Expression"):
        return str(expression)
    named = filter(None, map(_identifier, _names(facts)))
    return next(named, None)


def _names(facts: PackageMetadata) -> list[str]:
    """Return the names of a licence: its own first, as classifiers are less precise."""
    first_line = (facts.get("License") or "").partition("\n")[0].strip()
    classifiers = facts.get_all("Classifier") or []
    last = [each.rpartition(" :: ")[2] for each in classifiers if each.startswith("License ::")]
    return [first_line, *last]


def _identifier(name: str) -> str | None:
    if name in WORDS:
        return WORDS[name]
    return name if re.split(" OR | AND ", name)[0] in PERMITTED else None


def permitted(expression: str) -> bool:
    """Return whether all parts of an SPDX expression are, and of alternatives one is.

    >>> permitted("MIT OR Proprietary"), permitted("MIT AND Proprietary")
    (True, False)
    """
    if set(expression) & set("()"):
        return False  # nothing here has them, and a person is to look at what does
    alternatives = expression.split(" OR ")
    return any({*each.split(" AND ")} <= PERMITTED for each in alternatives)


def page(lock: Path = LOCK) -> str:
    """Return the text of the page.

    Raises
    ------
    ValueError
        Names the packages whose licences are not permitted, or not known.
    """
    found = {name: licence(name) for name in locked(lock)}
    if refused := [
        f"{name} ({expression or 'unknown'})"
        for name, expression in found.items()
        if expression is None or not permitted(expression)
    ]:
        raise ValueError(f"not permitted in a program under our licence: {', '.join(refused)}")
    rows = [f"| {name} | {expression} |\n" for name, expression in found.items()]
    return INTRODUCTION + "".join(rows)


if __name__ == "__main__":
    try:
        text = page()
    except ValueError as error:
        sys.exit(f"error: {error}")
    PAGE.write_text(text, encoding="utf-8")
