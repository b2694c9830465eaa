"""Let the built site ask nothing of other machines, and see that it does not."""

import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.utils import get_relative_url

# What a browser loads by itself; plain links are not loaded.
LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed|object)\b[^>]*\b(?:src|data|srcset)=["']?(?:https?:)?//"""
    r"""|<link\b(?=[^>]*\brel=["']?(?:stylesheet|preload|preconnect|icon|manifest|dns-prefetch))"""
    r"""[^>]*\bhref=["']?(?:https?:)?//"""
)
STYLE = re.compile(r"""@import\s+["']?(?:https?:)?//|url\(["']?(?:https?:)?//""")

# The theme has this from elsewhere; ours does the same.
SHIM, OURS = "https://unpkg.com/iframe-worker/shim", "assets/folder_search.js"


def on_post_page(output: str, page: Any, **_: Any) -> str:
    """Take our own script for the search in pages read from a folder."""
    return output.replace(SHIM, get_relative_url(OURS, page.url))


def on_post_template(output_content: str, template_name: str, **_: Any) -> str:
    """Do the same to pages that are none, such as that of wrong addresses."""
    return output_content.replace(SHIM, get_relative_url(OURS, template_name))


def on_post_build(config: Any) -> None:
    """Look through all pages and styles."""
    site = Path(config.site_dir)
    for path in sorted(site.rglob("*")):
        pattern = {".html": LOADED, ".css": STYLE}.get(path.suffix)
        if pattern is None:
            continue
        match = pattern.search(path.read_text(encoding="utf-8"))
        if match is not None:
            raise PluginError(f"{path.relative_to(site)} loads from elsewhere: {match[0]}")
