"""The operator's console of a session that `run` takes somebody through."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import dialogue, warn

if TYPE_CHECKING:
    from vrcomfort.console import OperatorConsole
    from vrcomfort.operator_interface import ProgressCallback
    from vrcomfort.protocol.texts import Words
    from vrcomfort.session.operator_control import OperatorControl
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.session.verbal import VerbalRespondent


@dataclass(frozen=True)
class ConsoleSetup:
    """A page that shows the session and steers it."""

    desk: OperatorConsole
    operators: OperatorControl

    @property
    def progress(self) -> ProgressCallback:
        """Return what shows how far a step has come."""
        return self.desk.tell

    def respondent(self, screen: PanelScreen | None, words: Words) -> VerbalRespondent:
        """Return a respondent whose answers are entered on the page; `words` stand in a headset."""
        from vrcomfort.session.verbal import VerbalRespondent

        return VerbalRespondent(self.desk, self.operators, screen, words=words)


@contextmanager
def open_console() -> Iterator[ConsoleSetup]:
    """Start the page's server and print its address; it ends with the session.

    Raises
    ------
    InputError
        If it does not start.
    """
    from vrcomfort.console import OperatorConsole, ServerProcess
    from vrcomfort.headset.eye_painter import EyePictures
    from vrcomfort.session.operator_control import OperatorControl

    terminal = dialogue()

    def tell_address(address: str) -> None:
        terminal.print(f"console, for the next operator, once: {address}", soft_wrap=True)

    with ServerProcess(warn, tell_address) as server:
        pictures = EyePictures()
        desk = OperatorConsole(server, say=terminal.print, pictures=pictures)
        try:
            yield ConsoleSetup(desk, OperatorControl(desk))
        finally:
            pictures.release()
