"""The operator's console of a session that `run` takes somebody through."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import dialogue, warn

if TYPE_CHECKING:
    from vrcomfort.console import ConsoleDesk, VerbalRespondent
    from vrcomfort.protocol.texts import Words
    from vrcomfort.session import ProgressCallback
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.session.steering import Steering


@dataclass(frozen=True)
class OperatorsConsole:
    """A page that shows the session and steers it."""

    desk: ConsoleDesk
    steering: Steering

    @property
    def progress(self) -> ProgressCallback:
        """Return what shows how far a step has come."""
        return self.desk.tell

    def respondent(self, screen: PanelScreen | None, words: Words) -> VerbalRespondent:
        """Return a respondent whose answers are entered on the page; `words` stand in a headset."""
        from vrcomfort.console import VerbalRespondent

        return VerbalRespondent(self.desk, self.steering, screen, words=words)


@contextmanager
def open_console() -> Iterator[OperatorsConsole]:
    """Start the page's server and print its address; it ends with the session.

    Raises
    ------
    InputError
        If it does not start.
    """
    from vrcomfort.console import ConsoleDesk, ServerProcess
    from vrcomfort.headset.eye_pictures import EyePictures
    from vrcomfort.session.steering import ALLOWED, Steering

    terminal = dialogue()

    def tell_address(address: str) -> None:
        terminal.print(f"console, for the next operator, once: {address}", soft_wrap=True)

    with ServerProcess(warn, tell_address) as server:
        pictures = EyePictures()
        desk = ConsoleDesk(server, ALLOWED, say=terminal.print, pictures=pictures)
        try:
            yield OperatorsConsole(desk, Steering(desk))
        finally:
            pictures.release()
