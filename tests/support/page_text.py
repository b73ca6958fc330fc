"""The text of a report's page: what is there on load, and what closed parts keep."""

from __future__ import annotations

import re
from html import unescape
from html.parser import HTMLParser

_SILENT = {"script", "style", "title", "svg"}
_VOID = {"meta", "br", "wbr", "hr", "img", "input", "link"}


class _VisibleText(HTMLParser):
    """Collects text that is neither in a closed `details` (but for its summary) nor hidden."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag, attrs):
        if tag not in _VOID:
            self.open.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        while self.open and self.open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        for place, (tag, attributes) in enumerate(self.open):
            inner = self.open[place + 1][0] if place + 1 < len(self.open) else ""
            closed = tag == "details" and "open" not in attributes and inner != "summary"
            if closed or tag in _SILENT or "hidden" in attributes:
                return
        self.text.append(data)


def visible_text(page: str) -> str:
    """Return the text that a reader sees when the page has loaded, without that of figures."""
    reader = _VisibleText()
    reader.feed(re.sub(r"<svg.*?</svg>", "", page, flags=re.DOTALL))
    return " ".join(" ".join(reader.text).split())


def word_count(text: str) -> int:
    """Return the number of words and numbers."""
    return len(re.findall(r"\w+(?:[.’'-]\w+)*", text))


def sentences(page: str) -> list[str]:
    """Return the sentences of a page's running text, tables and the text for a paper left out."""
    page = re.sub(r"<(svg|style|script|pre)\b.*?</\1>", "", page, flags=re.DOTALL)
    page = page.partition('<div class="refs">')[0]
    found = re.findall(r"<(p|li|dd|figcaption)\b[^>]*>(.*?)</\1>", page, flags=re.DOTALL)
    texts = (" ".join(unescape(re.sub(r"<[^>]+>", "", text)).split()) for _, text in found)
    return [each for text in texts for each in re.split(r"(?<=[.!?])\s+(?=[A-Z“])", text)]
