"""Commands; the only place where the parts are wired together."""

from __future__ import annotations

from vrcomfort.cli import stopping

__all__ = ["main"]


def main() -> None:
    """Run the command line; Ctrl-C while it is still being imported ends it without a word."""
    with stopping.heard():
        with stopping.at_once():
            from vrcomfort.cli import app
        app.main()
