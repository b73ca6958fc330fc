"""Write the table of controllers in docs/openxr.md from the bindings."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.headset.openxr.profiles import TABLE_HEAD, table

PAGE = Path(__file__).parent.parent / "docs" / "openxr.md"
FROM, TO = "<!-- made by scripts/controllers_table.py -->\n", "<!-- end of the table -->\n"
LOOKS = ("eyes, or else the head", "two looks", "–", "a look down", "–")


def markdown() -> str:
    """Return the rows as the page has them."""
    rows = [TABLE_HEAD, ("---",) * len(TABLE_HEAD), *table(), LOOKS]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


if __name__ == "__main__":
    before, _, rest = PAGE.read_text("utf-8").partition(FROM)
    PAGE.write_text(f"{before}{FROM}{markdown()}{TO}{rest.partition(TO)[2]}", encoding="utf-8")
