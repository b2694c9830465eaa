"""What the optimum uses of an engine file, as `crankfem.files.engine.used_values` tells it."""

from collections.abc import Iterable, Mapping

from crankfem.files.engine.used_values import (
    ALL,
    AXIAL_ALONE,
    TORSIONAL_ALONE,
    UNFORCED,
    Use,
)
from crankfem.files.engine.used_values import THROW as THROWS
from crankfem.files.reading.toml_file import TomlFile

RECIPROCATING = "vibration.reciprocating"
# By the frequencies that a search calculates.
USES: Mapping[str, Use] = {
    "": ((*THROWS, "material"), ()),
    "axial": ((ALL,), (*UNFORCED, *TORSIONAL_ALONE)),
    "torsional": ((ALL, RECIPROCATING), (*UNFORCED, *AXIAL_ALONE)),
    "axial and torsional": ((ALL, RECIPROCATING), UNFORCED),
}


def frequencies(vary: object, minimize: str, limits: Iterable[str] | None, **others: object) -> str:
    """Return the key in `USES` of a search with these arguments of the command: with `vary` both or none."""
    texts = " ".join([minimize, *(limits or ())])
    kinds = [
        kind
        for kind in ("axial", "torsional")
        if others[name := f"first_{kind}_frequency"] or (vary and name in texts)
    ]
    return " and ".join(("axial", "torsional") if kinds and vary else kinds)


def used_sections(_: TomlFile, case: str = "") -> Use:
    """Return the sections and fields that a search uses, and those that it does not."""
    return USES[case]
