"""The API reference: its pages, made from the public names when the site is built, and links to it."""

import re
from functools import cache
from pathlib import Path
from typing import Any

from api_topics import pages, public_names
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.utils import get_relative_url

# Names such as `cf.Chain` and `cf.chains.Gear` in the text, not where they stand in a link already.
NAMED = re.compile(r"(?P<before><a [^>]*>)?<code>(?P<name>cf\.(?:\w+\.)?\w+)(?:\([^<]*\))?</code>")

names = cache(public_names)


def on_files(files: Files, config: Any) -> Files:
    """Add a page for crankfem itself and each topic, and the index."""
    names.cache_clear()
    for path, text in pages(names()).items():
        written = files.get_file_from_path(path)
        if written is not None:  # what stands in the index's place where no site is built
            files.remove(written)
        files.append(File.generated(config, path, content=text))
    return files


def on_page_content(text: str, page: Any, **_: Any) -> str:
    """Link the names of a page to the reference; outside of the site they are plain code."""
    if "<code>cf." not in text:
        return text
    places = {one.shown: one for one in names()}

    def link(match: re.Match[str]) -> str:
        name = match["name"]
        if match["before"] or name not in places:
            return match[0]
        address = get_relative_url(f"api/{places[name].file}.html", page.url)
        return f'<a class="name" href="{address}#{places[name].path}">{match[0]}</a>'

    return NAMED.sub(link, text)


def on_post_build(config: Any) -> None:
    """See that every public name has its place in the built reference."""
    site = Path(config.site_dir)
    text = "".join(path.read_text(encoding="utf-8") for path in (site / "api").glob("*.html"))
    missing = [one.path for one in names() if f'id="{one.path}"' not in text]
    if missing:
        raise PluginError(f"not in the API reference: {', '.join(missing)}")
