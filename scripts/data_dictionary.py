"""Write docs/data_dictionary.md from the declarations of a study's tables and events."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.records.schema import data_dictionary

PAGE = Path(__file__).parent.parent / "docs" / "data_dictionary.md"

if __name__ == "__main__":
    PAGE.write_text(data_dictionary(), encoding="utf-8")
