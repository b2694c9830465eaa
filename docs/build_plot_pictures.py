"""Draw the pictures of docs/plots.md by the page's own code: takes some seconds."""

import os
import re
import shutil
import tempfile
from pathlib import Path

import matplotlib as mpl

from crankbase.diagrams import REPRODUCIBLE

HERE = Path(__file__).resolve().parent
PAGE = HERE / "plots.md"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


def main() -> None:
    """Run the page in an empty folder and keep the pictures that it writes."""
    mpl.use("svg")
    # Files that are the same bit for bit each time.
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder, mpl.rc_context(REPRODUCIBLE):
        os.chdir(folder)
        for block in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
            exec(compile(block, PAGE.name, "exec"), names)
        for picture in sorted(Path(folder).glob("*.svg")):
            shutil.copy(picture, HERE / picture.name)
            print(picture.name)
        os.chdir(HERE)


if __name__ == "__main__":
    main()
