"""A build hook: wheels carry the documentation site (pyproject.toml)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class SiteInWheel(BuildHookInterface[Any]):
    """Builds the site, except for an editable installation: a checkout has `make docs`."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the pages, and say where they belong."""
        if version == "editable":
            return
        self._folder = TemporaryDirectory()
        site = Path(self._folder.name) / "site"
        command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(site)]
        subprocess.run(command, cwd=self.root, check=True)
        build_data["force_include"][str(site)] = "vrcomfort/_data/site"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the pages, which are in the wheel now."""
        del build_data, artifact_path
        if version != "editable":
            self._folder.cleanup()
