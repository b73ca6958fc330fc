"""The operator's console: a page on this machine that shows a session and steers it.

The web server is a process of its own (`server`), which the session talks to through two pipes
(`process`): small messages, the oldest of which are dropped where the server is slow. Nothing here
is imported by `session`; the command line joins the two by the shapes in `session.interfaces`.
"""

from vrcomfort.console.desk import ConsoleDesk
from vrcomfort.console.process import ServerProcess
from vrcomfort.console.verbal import VerbalRespondent

__all__ = ["ConsoleDesk", "ServerProcess", "VerbalRespondent"]
