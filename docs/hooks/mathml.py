"""Turn formulas between dollar signs into MathML, which browsers show without any script."""

import html
import re
from typing import Any

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError

# What pymdownx.arithmatex makes of $...$ and $$...$$.
FORMULA = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\(?P<bracket>[(\[])(?P<latex>.*?)\\[)\]]</(?P=tag)>',
    re.DOTALL,
)
# Of a command that the converter does not know it leaves the name.
UNKNOWN = re.compile(r">\s*(\\[A-Za-z]+)\s*<")
STRAY = "<mi>&</mi>"  # the mark of a column, outside of an environment that it knows
# Names of functions that LaTeX has and the converter lacks.
FUNCTIONS = re.compile(r"\\(arg|deg|dim|hom|ker|sgn|Re|Im)(?![A-Za-z])")


def on_page_content(text: str, page: Any, **_: Any) -> str:
    """Convert the formulas of a page."""

    def formula(match: re.Match[str]) -> str:
        latex = html.unescape(match["latex"]).strip()
        block = match["bracket"] == "["
        try:
            named = FUNCTIONS.sub(r"\\operatorname{\1}", latex).replace("{aligned}", "{split}")
            made = convert(named, display="block" if block else "inline")
        except Exception as error:
            raise PluginError(f"{page.file.src_uri}: {latex!r} is no formula ({error!r})") from None
        unknown = UNKNOWN.search(made)
        if unknown is not None:
            raise PluginError(f"{page.file.src_uri}: {unknown[1]} of {latex!r} is not known")
        if STRAY in made:
            raise PluginError(f"{page.file.src_uri}: an environment of {latex!r} is not known")
        return f'<div class="formula">{made}</div>' if block else made

    return FORMULA.sub(formula, text)
