"""Draw the pictures of docs/throws.md with the current code: ``python docs/build_pictures.py``."""

from pathlib import Path

import crankfem as cf
from crankfem.pictures.drawing import write_drawing

HERE = Path(__file__).parent
ENGINE = "8chn26-26"


def main() -> None:
    """Write the drawing of a throw and the picture of a whole crankshaft."""
    throw, _ = cf.load_throw(ENGINE)
    write_drawing(throw, HERE / "drawing.svg", "8ChN 26/26")
    cf.picture_shaft(cf.load_crankshaft(ENGINE), HERE / "crankshaft.png")


if __name__ == "__main__":
    main()
