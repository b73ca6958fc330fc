"""The operator's console: a page on this machine that shows a session and steers it.

The web server is a process of its own (`server`), which the session talks to through two pipes
(`process`): small messages, the oldest of which are dropped where the server is slow. Nothing here
is imported by `session`, nor the other way round: both know `operator_interface`.
"""

from vrcomfort.console.desk import OperatorConsole
from vrcomfort.console.process import ServerProcess

__all__ = ["OperatorConsole", "ServerProcess"]
