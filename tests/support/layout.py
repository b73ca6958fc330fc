"""How a page lies in a window of a given width: what of it cannot be read."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path

from tests.support.browser import open_page

MEASURE = """<script>
addEventListener('load', () => {
  const width = document.documentElement.clientWidth;
  const inside = (e) => e.getBoundingClientRect().right <= width + 1;
  const scrolls = (e) => e && inside(e) && getComputedStyle(e).overflowX === 'auto';
  const cut = [...document.querySelectorAll('table, svg, p, h1, h2, li, dd, pre, nav a')]
    .filter((e) => e.getBoundingClientRect().width && !inside(e) && !scrolls(e.closest('.scroll')))
    .map((e) => e.tagName + ' ' + e.textContent.trim().slice(0, 60));
  const parts = [...document.querySelectorAll('details.part > .inside')];
  const hidden = parts.filter((e) => !e.checkVisibility()).length;
  const found = {hidden, parts: parts.length, width,
    scroll_width: document.documentElement.scrollWidth, cut};
  parent.postMessage(JSON.stringify(found), '*');
});
</script>"""
LISTEN = """<!DOCTYPE html><title>waiting</title><pre></pre><script>
addEventListener('message', (e) => { document.querySelector('pre').textContent = e.data; });
</script>"""


def lay_out(browser: str, page: Path, width_px: int, *, printed: bool = False) -> dict:
    """Return the width of the window, that of what can be scrolled to, and what is cut.

    On screen all parts of the page are opened; on paper they have to open by themselves.
    """
    text = page.read_text("utf-8")
    if not printed:
        text = text.replace('<details class="part">', '<details class="part" open>')
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    if printed:
        text = text.replace("@media print", "@media all")
    name = f"{'printed' if printed else 'shown'}_{width_px}"
    copy = page.with_name(f"{name}.html")
    copy.write_text(text.replace("</body>", f"{MEASURE}</body>"), "utf-8")
    frame = page.with_name(f"{name}_frame.html")
    style = f"width:{width_px}px;height:800px;border:0"
    frame.write_text(f'{LISTEN}<iframe style="{style}" src="{copy.name}"></iframe>', "utf-8")
    found = re.search(r"<pre>(.*?)</pre>", open_page(browser, frame).dom, re.DOTALL)
    assert found is not None
    return json.loads(unescape(found[1]))
