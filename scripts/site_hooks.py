"""Pages of the documentation site that are files of the checkout's root (mkdocs.yml)."""

from __future__ import annotations

from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parent.parent
PAGES = {"conventions.md": "CONVENTIONS.md", "changelog.md": "CHANGELOG.md"}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages, with links as pages in docs/ have them."""
    for page, name in PAGES.items():
        text = (ROOT / name).read_text("utf-8").replace("](docs/", "](")
        files.append(File.generated(config, page, content=text))
    return files


def on_post_build(config: MkDocsConfig) -> None:
    """Remove the source maps of the theme's scripts: 1.3 MB in every wheel."""
    for file in Path(config.site_dir).rglob("*.map"):
        file.unlink()
