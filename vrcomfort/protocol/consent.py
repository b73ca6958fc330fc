"""Consent: in which version of the text participants must have given it."""

from __future__ import annotations

from vrcomfort.settings import Name, Settings


class Consent(Settings):
    """No session begins before the participant has consented in this version."""

    version: Name
    """Of the text; where it changes, everybody is asked again before their next session."""
    file: str = ""
    """The text, relative to the protocol file; its hash is recorded, so that no text changes
    under one version."""
