"""Shows how far the steps of a session have come."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import progress_bar, warn

if TYPE_CHECKING:
    from vrcomfort.operator_interface import SessionProgress


class SessionBars(ExitStack):
    """A bar for each exposure and rest; the questionnaires speak for themselves."""

    def __init__(self, quiet: bool) -> None:
        super().__init__()
        self._quiet = quiet
        self._title = ""
        self._done = 0.0

    def tell(self, progress: SessionProgress) -> None:
        """Show how far a step of the session has come, and what the operator must know at once."""
        if progress.step == "notice":
            warn(progress.text)
            return
        timed = progress.step in {"training", "exposure", "rest"}
        title = f"{progress.step} {progress.trial or ''}".strip() if timed else ""
        if title != self._title:
            self.close()
            self._title, self._done = title, 0.0
            if title:
                bar = progress_bar(title, progress.total, quiet=self._quiet, unit="s")
                self._advance = self.enter_context(bar)
        if title:
            self._advance(progress.done - self._done)
            self._done = progress.done
