"""The same figures of papers, for reports of a paper's own protocol."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class SameFigures:
    """The figures of one paper."""

    figures: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, protocol: str | None) -> SameFigures:
        """Return those of a protocol's paper; none for any other protocol."""
        file = data_folder("analysis") / "report" / "figures_of_sources.toml"
        known = tomllib.loads(file.read_text(encoding="utf-8"))
        return cls(known.get(protocol or "", {}))

    def with_figure(self, name: str) -> str:
        """Return “ (cf. …)”, or nothing."""
        found = self.figures.get(name)
        return f" (cf. {found})" if found else ""
