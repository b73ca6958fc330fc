"""Commands; the only place where the parts are wired together."""

from vrcomfort.cli.app import main

__all__ = ["main"]
