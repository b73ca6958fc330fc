"""Hooks of the documentation site: pages from the checkout's root, and titles as link texts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parent.parent
PAGES = {"conventions.md": "CONVENTIONS.md", "changelog.md": "CHANGELOG.md"}
NAMED = re.compile(r"\[(?:docs/)?\w+\.md\]\((\w+\.md)(#[\w-]*)?\)")
"""A link whose text is the file's name, which is what readers of the files want."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages, with links as pages in docs/ have them."""
    for page, name in PAGES.items():
        text = (ROOT / name).read_text("utf-8").replace("](docs/", "](")
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Give links the titles of their pages."""
    del page, files
    titles = dict(_titles(config.nav))
    return NAMED.sub(lambda found: _link(found[1], found[2] or "", titles), markdown)


def _link(page: str, anchor: str, titles: dict[str, str]) -> str:
    return f"[{titles.get(page, page)}]({page}{anchor})"


def _titles(nav: Any) -> Iterator[tuple[str, str]]:
    """Yield (file, title) of the navigation."""
    for entry in nav:
        for title, inner in entry.items():
            if isinstance(inner, str):
                yield inner, title
            else:
                yield from _titles(inner)


def on_post_build(config: MkDocsConfig) -> None:
    """Remove the source maps of the theme's scripts: 1.3 MB in every wheel."""
    for file in Path(config.site_dir).rglob("*.map"):
        file.unlink()
