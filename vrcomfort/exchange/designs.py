"""The design that a session was run with, from its manifest alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from vrcomfort.design import Design, build_design
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol


def protocol_of(manifest: Mapping[str, Any]) -> Protocol:
    """Return the protocol of a session as it was checked then, without its instruments.

    Raises
    ------
    InputError
        If this version knows no such settings.
    """
    try:
        return Protocol.model_validate(manifest.get("settings"))
    except ValidationError as error:
        name = manifest["protocol"]["name"]
        message = f"the settings of protocol `{name}` in this manifest are of another version"
        raise InputError(message) from error


def design_of(manifest: Mapping[str, Any]) -> Design:
    """Return the orders and groups of a session's study.

    Raises
    ------
    InputError
        As `protocol_of`.
    """
    return build_design(protocol_of(manifest), seed=manifest["seed"])
