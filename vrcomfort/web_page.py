"""The base of all written pages: escaped templates, inline SVG, no scripts but a known one.

Names of conditions, participants and studies come from files that anybody may have written. They
reach a page through two doors only: the templates of `page_templates`, which escape, and
`inline_svg`. Should something get through both, `POLICY` keeps it from running.
"""

from __future__ import annotations

import base64
import hashlib
import re

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from vrcomfort.escaping import escape_unprintable
from vrcomfort.resources import data_folder

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; "
    "base-uri 'none'; form-action 'none'"
)
"""The content security policy of a page: no scripts, nothing from elsewhere."""


def policy_with(script: str) -> str:
    """Return the policy of a page with one script, this one and no other."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return f"{POLICY}; script-src 'sha256-{digest}'"


_HIDDEN = re.compile(
    "[\u200b\u202a-\u202e\u2060-\u2069\ufeff"  # no width, or turns the text around it
    "\u115f\u1160\u2800\u3164\uffa0"  # letters without a shape
    "\ufff9-\ufffb\U000e0000-\U000e007f]"
)
_PLAIN = re.compile(r"[A-Za-z0-9_.-]+")


def page_templates() -> Environment:
    """Return the environment of the shipped templates; all output is escaped."""
    environment = Environment(
        loader=FileSystemLoader(data_folder("analysis")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: escape_hidden(value) if type(value) is str else value,
    )
    environment.globals["policy"] = POLICY
    return environment


def escape_hidden(text: str) -> str:
    r"""Return a text with ``\u202e`` in place of unprintable, invisible and bidi characters."""
    return escape_unprintable(escape_unprintable(text), _HIDDEN)


def inline_svg(svg: str, name: str, attributes: str = 'role="img"') -> Markup:
    """Return an SVG for use inside HTML: no XML prologue, and ids that no other figure has.

    Parameters
    ----------
    svg
        What matplotlib wrote, which escapes the text in it.
    name
        Of the figure; any text.
    attributes
        Of the svg element, as HTML.
    """
    # A name that is no plain word would end the attribute, or mean something to `re`.
    prefix = (
        name if _PLAIN.fullmatch(name) else f"f{hashlib.sha256(name.encode()).hexdigest()[:16]}"
    )
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r'(?<=id=")|(?<=href="#)|(?<=url\(#)', f"{prefix}-", svg)
    return Markup(svg.replace("<svg ", f"<svg {attributes} ", 1))  # noqa: S704 - see `svg`
