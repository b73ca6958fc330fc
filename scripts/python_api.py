"""Write docs/python_api.md from the signatures and docstrings of the public functions."""

from __future__ import annotations

import inspect
import re
from functools import cached_property
from pathlib import Path
from typing import Any

import vrcomfort
from vrcomfort import stats
from vrcomfort.api.views import RenderedEye, RenderedViews
from vrcomfort.records import Study

PAGE = Path(__file__).parent.parent / "docs" / "python_api.md"
HEADING = re.compile(r"^([A-Z][a-z]+)\n-+\n", re.MULTILINE)
INTRODUCTION = """# Python API

```python
import vrcomfort

study = vrcomfort.read_study("my_study")
scores = study.scores("ssq")
vrcomfort.stats.wilcoxon(scores, dv="total", within="condition", subject="participant")
```
These functions are public: their names and parameters stay. The command line calls them where both
do the same thing. [analysis_in_python.ipynb](analysis_in_python.ipynb) is an example. `import
vrcomfort` loads no other module; each is imported when a function of it is named. Bad input raises
`vrcomfort.InputError`: the message says what is wrong, where, and what to do. Notes on the data are
Python warnings. Times are seconds, lengths metres; columns of recorded tables are in
[data_dictionary.md](data_dictionary.md). `scripts/python_api.py` writes this page.
"""


def page() -> str:
    """Return the text of the page."""
    root = [name for name in vrcomfort.__all__ if name not in {"__version__", "stats"}]
    functions = [name for name in root if inspect.isfunction(getattr(vrcomfort, name))]
    parts = [INTRODUCTION, "## Studies, reports, views\n"]
    parts += [_entry(f"vrcomfort.{name}", getattr(vrcomfort, name)) for name in functions]
    parts += ["## Study\n", _entry("Study", Study), _properties(Study)]
    parts.append(_entry("Study.scores", Study.scores))
    parts += [
        "## Views\n",
        *(_entry(each.__name__, each) for each in (RenderedViews, RenderedEye)),
    ]
    parts.append(
        "## Statistics\n\nTidy data frames in, data frames out, as in pingouin. Conventions (ties, "
        "zeros, exact distributions, sums of squares): [statistics.md](statistics.md).\n"
    )
    parts += [_entry(f"vrcomfort.stats.{name}", getattr(stats, name)) for name in stats.__all__]
    return "\n".join(parts)


def _entry(name: str, what: Any) -> str:
    """Return heading, signature and docstring of one function or class."""
    head, *sections = HEADING.split(inspect.getdoc(what) or "")
    text = f"### {name}\n\n```python\n{_signature(name, what)}\n```\n{head.strip()}\n"
    for title, body in zip(sections[::2], sections[1::2], strict=True):
        language = "pycon" if title == "Examples" else "text"
        text += f"\n{title}:\n```{language}\n{body.strip()}\n```\n"
    return text


def _properties(kind: type) -> str:
    """Return a table of the public properties of a class, with the first line of each."""
    rows = [
        f"| `{name}` | {(inspect.getdoc(value) or '').splitlines()[0].removeprefix('Return ')} |"
        for name, value in vars(kind).items()
        if isinstance(value, property | cached_property) and not name.startswith("_")
    ]
    return "\n".join(["| property | |", "|---|---|", *rows, ""])


def _signature(name: str, what: Any) -> str:
    named = inspect.signature(what).parameters
    parameters = [each for each in named.values() if each.name != "self"]
    lines, named_only = [], False
    for each in parameters:
        if each.kind is each.KEYWORD_ONLY and not named_only:
            lines.append("*")
            named_only = True
        default = "" if each.default is each.empty else f"={_default(each.default)}"
        lines.append(each.name + default)
    return f"{name}({', '.join(lines)})"


def _default(value: Any) -> str:
    return value.__name__ if callable(value) else repr(value)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
