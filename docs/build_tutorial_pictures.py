"""Draw the pictures of the tutorials with their own code: ``python docs/build_tutorial_pictures.py``.

Runs the blocks of each page in order in an empty folder, as a reader would, and keeps the pictures that
the page shows. Names of pages as arguments draw theirs alone.
"""

import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
from cycler import cycler

from crankbase.diagrams import COLORS, STYLE

TUTORIALS = Path(__file__).resolve().parent / "tutorials"
# Page to its pictures: what its code writes, and what it is called beside the page.
PICTURES = {
    "new-engine": {
        "five-throw.svg": "new-engine-throw.svg",
        "new-engine-stress.svg": "new-engine-stress.svg",
    },
    "cluster-study": {"cluster-study-compliance.svg": "cluster-study-compliance.svg"},
    "torque-to-resonance": {"torque-to-resonance-stress.svg": "torque-to-resonance-stress.svg"},
    "v-engine": {"v8-crankpin.svg": "v-engine-crankpin.svg"},
    "slow-speed-plant": {"slow-speed-plant-stress.svg": "slow-speed-plant-stress.svg"},
    "hinge": {"hinge-guide.svg": "hinge-guide.svg"},
}
BLOCK = re.compile(
    r'(?P<skipped><!-- not run:[^>]*-->\n)?^```(?P<language>\w+)(?: title="(?P<title>[^"]+)")?\n'
    r"(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
LOOK = STYLE | {"axes.prop_cycle": cycler(color=COLORS), "figure.constrained_layout.use": True}


def main() -> None:
    """Draw the pictures of all pages, or of those named."""
    mpl.use("Agg")
    os.environ["SOURCE_DATE_EPOCH"] = (
        "0"  # no date in the files, so that they change with the picture alone
    )
    for name in sys.argv[1:] or PICTURES:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            with mpl.rc_context(LOOK), contextlib.redirect_stdout(io.StringIO()):
                run_blocks((TUTORIALS / f"{name}.md").read_text(encoding="utf-8"))
            for made, kept in PICTURES[name].items():
                shutil.copyfile(made, TUTORIALS / kept)
                print(f"{kept}: {os.path.getsize(made) / 1024:.0f} kB")


def run_blocks(page: str) -> None:
    """Run the Python blocks and the crankfem lines of a page, and write its files."""
    from crankfem.cli import app as cli

    names: dict[str, object] = {"__name__": "__main__"}
    for block in BLOCK.finditer(page):
        if block["skipped"]:
            continue
        if block["title"]:
            Path(block["title"]).write_text(block["text"], encoding="utf-8")
        elif block["language"] == "python":
            exec(block["text"], names)
        elif block["language"] == "sh":
            for line in block["text"].replace("\\\n", " ").splitlines():
                words = shlex.split(line, comments=True)
                if words[:1] == ["crankfem"]:
                    sys.argv = words
                    with contextlib.suppress(SystemExit):
                        cli.main()


if __name__ == "__main__":
    main()
