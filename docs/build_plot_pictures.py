"""Draw the pictures of docs/plots.md and docs/gallery.md by the pages' own code: a minute or two."""

import contextlib
import os
import re
import shutil
import tempfile
from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt

from crankbase.diagrams import REPRODUCIBLE

HERE = Path(__file__).resolve().parent
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
FOLDERS = {"plots": HERE, "gallery": HERE / "gallery"}  # of the pictures of each page


def main() -> None:
    """Run each page in an empty folder and keep the pictures that it writes."""
    mpl.use("agg")
    # Files that are the same bit for bit each time.
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    for page, kept in FOLDERS.items():
        names: dict[str, object] = {}
        text = (HERE / f"{page}.md").read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            with mpl.rc_context(REPRODUCIBLE):
                for block in BLOCK.findall(text):
                    exec(compile(block, page, "exec"), names)
            plt.close("all")
            for picture in sorted(Path(folder).glob("*.[sp][vn]g")):
                shutil.copy(picture, kept / picture.name)
                print(f"{picture.name}: {picture.stat().st_size / 1024:.0f} kB")


if __name__ == "__main__":
    main()
