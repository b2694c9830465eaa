"""Draw docs/developers/map.svg, the code overview, from the code: takes a second.

Packages and their layers are those of pyproject.toml's import contracts, arrows are what the packages
import, and the lines are the first sentences of the modules. A test compares.
"""

import ast
import re
import textwrap
import tomllib
from functools import cache
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[1]
DRAWING = ROOT / "docs" / "developers" / "map.svg"
# Of packages whose inside has no contract, the modules to begin with.
MAIN = {
    "fem": (
        ("analysis",),
        ("responses",),
        ("modes",),
        ("superelement",),
        ("solver",),
    ),
    "geometry": (("mesher",), ("mesh",), ("solid",), ("parts",), ("throw",)),
    "crankbase": (("table",), ("model",), ("quantity",), ("choices",), ("processes",), ("errors",)),
}
WIDTH, MARGIN, GAP, PADDING = 720, 10, 34, 10
COLUMN = (WIDTH - 2 * MARGIN - 20) // 2
LINE, NAME, LETTERS = 14, 17, 48
COLORS = {
    "crankfem": "#1f5f99",
    "dynamics": "#8a4f00",
    "regression": "#5b3a8c",
    "fem": "#0b6b4f",
    "geometry": "#4a4a4a",
    "crankbase": "#7a1f3d",
}
# Anywhere in a module, for some are imported where they are needed.
IMPORT = re.compile(r"^[ \t]*(?:from[ ]+(?=[\w.]+[ ]+import\b)|import[ ]+)(\w+)", re.MULTILINE)
Layers = tuple[tuple[str, ...], ...]


def contracts() -> dict[str, Layers]:
    """Return the layers between packages ("") and of the packages that have some, the highest first."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    found: dict[str, Layers] = {}
    for contract in tomllib.loads(text)["tool"]["importlinter"]["contracts"]:
        if contract["type"] == "layers":
            layers = tuple(tuple(layer.split(" | ")) for layer in contract["layers"])
            found[contract.get("containers", [""])[0]] = layers
    return found


def imports(package: str, packages: set[str]) -> set[str]:
    """Return which other packages one imports, by its own text."""
    found: set[str] = set()
    for path in (ROOT / package).rglob("*.py"):
        found |= set(IMPORT.findall(path.read_text(encoding="utf-8")))
    return (found & packages) - {package}


@cache
def arrows() -> set[tuple[str, str]]:
    """Return the imports between packages, without those that go by way of a third."""
    packages = {name for layer in contracts()[""] for name in layer}
    direct = {name: imports(name, packages) for name in packages}
    return {
        (one, other)
        for one, others in direct.items()
        for other in others
        if not any(other in direct[between] for between in others)
    }


def sentence(package: str, module: str) -> str:
    """Return the first sentence of a module or package, without its period."""
    folder = ROOT / package / module
    path = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    first = re.split(r"(?<!\.)\. (?=[A-Z])", " ".join(text.split("\n\n")[0].split()))[0]
    return first.rstrip(".").replace("`", "")


def _entries(package: str, layer: tuple[str, ...]) -> list[tuple[str, list[str]]]:
    return [(name, textwrap.wrap(sentence(package, name), LETTERS)) for name in layer]


def _height(entries: list[tuple[str, list[str]]]) -> int:
    return sum(NAME + LINE * len(lines) + 3 for _, lines in entries) + 6


def _bands(package: str, layers: Layers, x: int, y: int, columns: int) -> tuple[list[str], int]:
    """Draw the layers of a package as bands from (x, y) down; return them and where they end."""
    drawn: list[str] = []
    bands = [_entries(package, layer) for layer in layers]
    share = -(-len(bands) // columns)
    end = y
    for column in range(columns):
        left, top = x + column * (COLUMN + 20), y
        for entries in bands[column * share : (column + 1) * share]:
            height = _height(entries)
            drawn.append(
                f'<rect x="{left + PADDING}" y="{top}" width="{COLUMN - 2 * PADDING}" '
                f'height="{height}" rx="4" fill="#ffffff" stroke="#c9cdd2"/>'
            )
            at = top + 3
            for name, lines in entries:
                at += NAME
                drawn.append(
                    f'<text x="{left + PADDING + 8}" y="{at - 3}" class="name">{escape(name)}</text>'
                )
                for line in lines:
                    at += LINE
                    drawn.append(
                        f'<text x="{left + PADDING + 8}" y="{at - 4}">{escape(line)}</text>'
                    )
                at += 3
            top += height + 5
        end = max(end, top)
    return drawn, end


def _box(package: str, layers: Layers, x: int, y: int, columns: int = 1) -> tuple[list[str], int]:
    """Draw a package with its layers; return it and where it ends."""
    width = COLUMN if columns == 1 else WIDTH - 2 * MARGIN
    said = sentence(package, "__init__").split(": ")[-1]
    lines = textwrap.wrap(said, LETTERS * columns)
    inner, end = _bands(package, layers, x, y + 26 + LINE * len(lines) + 4, columns)
    color = COLORS[package]
    drawn = [
        f'<rect x="{x}" y="{y}" width="{width}" height="{end - y + 4}" rx="8" fill="{color}" '
        f'fill-opacity="0.10" stroke="{color}" stroke-width="1.5"/>',
        f'<text x="{x + PADDING}" y="{y + 20}" class="package" fill="{color}">{package}</text>',
        *(
            f'<text x="{x + PADDING}" y="{y + 22 + LINE * (row + 1)}">{escape(line)}</text>'
            for row, line in enumerate(lines)
        ),
    ]
    return drawn + inner, end + 4


def drawing() -> str:
    """Return the SVG: crankfem, below it dynamics beside regression, fem and geometry, at last crankbase."""
    layers = contracts()
    order = {name: MAIN.get(name) or layers[name] for row in layers[""] for name in row}
    left, right = MARGIN, MARGIN + COLUMN + 20
    body, face = _box("crankfem", order["crankfem"], left, MARGIN, 2)
    places = {"crankfem": (MARGIN, face)}
    for package, x, top in (("dynamics", left, face + GAP), ("regression", right, face + GAP)):
        drawn, end = _box(package, order[package], x, top)
        body, places = body + drawn, places | {package: (top, end)}
    top = places["regression"][1] + GAP
    drawn, end = _box("fem", order["fem"], right, top)
    body, places["fem"] = body + drawn, (top, end)
    drawn, end = _box("geometry", order["geometry"], right, end + GAP)
    body, places["geometry"] = body + drawn, (places["fem"][1] + GAP, end)
    top = max(end, places["dynamics"][1]) + GAP
    drawn, height = _box("crankbase", order["crankbase"], left, top, 2)
    body, places["crankbase"] = body + drawn, (top, height)
    middles = {"dynamics": left + COLUMN // 2}
    for one, other in sorted(arrows()):
        at = middles.get(one) or middles.get(other) or right + COLUMN // 2
        start, stop = places[one][1] + 3, places[other][0] - 3
        body.append(
            f'<line x1="{at}" y1="{start}" x2="{at}" y2="{stop - 6}" class="arrow" '
            f'marker-end="url(#tip)"><title>{one} imports {other}</title></line>'
        )
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height + MARGIN}" '
            f'width="{WIDTH}" height="{height + MARGIN}" role="img">',
            "<title>Packages of crankfem, their layers and main modules; imports run downwards</title>",
            "<style>text{font:11.5px Helvetica,Arial,sans-serif;fill:#222}"
            ".name{font:bold 12px Consolas,Menlo,monospace}.package{font:bold 16px "
            "Helvetica,Arial,sans-serif}.arrow{stroke:#222;stroke-width:2}</style>",
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="2" refY="4" markerWidth="5" '
            'markerHeight="5" orient="auto"><path d="M0 0 8 4 0 8z" fill="#222"/></marker></defs>',
            f'<rect width="{WIDTH}" height="{height + MARGIN}" fill="#ffffff"/>',
            *body,
            "</svg>\n",
        ]
    )


if __name__ == "__main__":
    DRAWING.write_text(drawing(), encoding="utf-8")
