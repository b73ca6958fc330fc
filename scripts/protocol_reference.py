"""Write docs/protocol_reference.md from the models that read protocols."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.protocol.reference import protocol_reference

PAGE = Path(__file__).parent.parent / "docs" / "protocol_reference.md"

if __name__ == "__main__":
    PAGE.write_text(protocol_reference(), encoding="utf-8")
