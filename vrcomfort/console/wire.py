"""Messages through a pipe: four bytes of length, one of kind, then JSON or a picture."""

from __future__ import annotations

import json
import struct
from typing import IO, Any, Literal, TypeAlias

Kind: TypeAlias = Literal[b"j", b"p"]
JSON: Kind = b"j"
PICTURE: Kind = b"p"

_HEAD = struct.Struct("<Ic")
# A longer length is no message: the stream is out of step.
LONGEST_BYTES = 1 << 24


def packed(content: Any) -> bytes:
    """Return a message that holds plain JSON."""
    return framed(JSON, json.dumps(content, allow_nan=False, separators=(",", ":")).encode())


def unpacked(body: bytes) -> dict[str, Any]:
    """Return the object that a body of JSON holds."""
    content: dict[str, Any] = json.loads(body)
    return content


def framed(kind: Kind, body: bytes) -> bytes:
    """Return a message."""
    return _HEAD.pack(len(body), kind) + body


def read_message(stream: IO[bytes]) -> tuple[bytes, bytes] | None:
    """Wait for a message; return its kind and body, or None where the other end is gone."""
    try:
        head = stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        length, kind = _HEAD.unpack(head)
        body = stream.read(length) if length <= LONGEST_BYTES else b""
    except (OSError, ValueError):  # closed meanwhile
        return None
    return (kind, body) if len(body) == length else None
