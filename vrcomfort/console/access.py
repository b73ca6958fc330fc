"""Access to a console: a one-time token, then a cookie; and the permitted origins.

The server listens on the loopback interface alone. That keeps other machines out, but neither other
people on this one (they have no token) nor pages of other sites in the operator's browser (their
origin, and by name tricks their host, are others).
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field

NO_COOKIE = (
    "This console opens with the address that the terminal printed. Each address works once: the "
    "terminal has the next one."
)
OTHER_HOST = "This console is reached at http://127.0.0.1 alone."
OTHER_ORIGIN = "Pages of other origins may not use this console."


def new_secret() -> str:
    """Return 256 random bits for an address."""
    return secrets.token_urlsafe(32)


@dataclass
class ConsoleAccess:
    """Credentials of one console.

    Parameters
    ----------
    port
        Where it listens.
    key
        Signs the cookies; the same after a restart of the server, so that pages stay open.
    token
        Opens it next, once.
    operators
        How many have come in.
    """

    port: int
    key: str = field(default_factory=new_secret, repr=False)
    token: str = field(default_factory=new_secret, repr=False)
    operators: int = 0

    @property
    def cookie_name(self) -> str:
        """Return the cookie's name: ports share the cookies of a host."""
        return f"vrcomfort_console_{self.port}"

    @property
    def address(self) -> str:
        """Return the address for the next operator."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    def exchange(self, token: str) -> str | None:
        """Exchange the token, once, for an operator's cookie; return None for another token."""
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return None
        self.token = new_secret()
        self.operators += 1
        name = operator_name(self.operators)
        return f"{name}.{self._signature(name)}"

    def operator(self, cookie: str | None) -> str | None:
        """Return the cookie's operator; None for an invalid one."""
        name, _, signature = (cookie or "").partition(".")
        if not name or not hmac.compare_digest(signature.encode(), self._signature(name).encode()):
            return None
        return name

    def refusal(self, headers: Mapping[str, str], *, socket: bool) -> str:
        """Return why a request from elsewhere is refused; blank where it is not.

        Parameters
        ----------
        socket
            A web socket: browsers send its origin always, and let every page open one.
        """
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in {f"127.0.0.1:{self.port}", f"localhost:{self.port}"}:
            return OTHER_HOST
        if origin is None:
            return OTHER_ORIGIN if socket else ""
        return "" if origin == f"http://{host}" else OTHER_ORIGIN

    def _signature(self, name: str) -> str:
        return hmac.new(self.key.encode(), name.encode(), hashlib.sha256).hexdigest()


def operator_name(number: int) -> str:
    """Return A to Z, then A2 to Z2, and so on."""
    turn, letter = divmod(number - 1, 26)
    return chr(ord("A") + letter) + (str(turn + 1) if turn else "")
