"""The solids of a CAD file, and the crankshaft among them."""

from collections.abc import Callable, Sequence
from typing import Annotated, Any

import numpy as np

from crankbase.errors import InputError
from crankbase.results import Quantity, Result, result
from geometry.faces import measured_face
from geometry.shaft_shape import Line, crank_line

# The kernel's tolerances are made for lengths in mm, in which it reads files.
MM = 1e-3
Place = tuple[float, float, float]


@result("name", "volume", "what")
class SolidInFile(Result):
    """A solid of a STEP file, in the file's frame.

    Attributes
    ----------
    name : str
        As the file has it, made unlike the names before it.
    what : str
        Empty for a crankshaft, else what it is instead.
    """

    name: str
    volume: Annotated[float, Quantity("m^3")]
    center: Annotated[Place, Quantity("m")]
    low: Annotated[Place, Quantity("m", "corner of its box")]
    high: Annotated[Place, Quantity("m", "corner of its box")]
    what: str


def measured_solid(gmsh: Any, tag: int, number: int) -> tuple[SolidInFile, Line | str]:
    """Measure a solid in gmsh, the one of a number in its file, and look for a shaft axis."""
    occ = gmsh.model.occ
    label = str(gmsh.model.getEntityName(3, tag)).rpartition("/")[2] or "solid"
    box = [MM * float(value) for value in gmsh.model.getBoundingBox(3, tag)]
    low, high = (box[0], box[1], box[2]), (box[3], box[4], box[5])
    line = _line(gmsh, tag)
    x, y, z = (MM * float(value) for value in occ.getCenterOfMass(3, tag))
    volume = MM**3 * float(occ.getMass(3, tag))
    what = line if isinstance(line, str) else ""
    return SolidInFile(f"{number} {label}", volume, (x, y, z), low, high, what), line


def is_built_up(gmsh: Any, solids: Sequence[int]) -> bool:
    """Whether several solids are a crankshaft together, as pressed ones are."""
    return len(solids) > 1 and isinstance(_line(gmsh, *solids), Line)


def _line(gmsh: Any, *solids: int) -> Line | str:
    """Look for the axis of a crankshaft of one solid or several."""
    boxes = np.array([gmsh.model.getBoundingBox(3, tag) for tag in solids])
    size = float(np.linalg.norm(boxes[:, 3:].max(axis=0) - boxes[:, :3].min(axis=0)))
    parts = [(3, tag) for tag in solids]
    sides = gmsh.model.getBoundary(parts, combined=False, oriented=False)
    return crank_line([measured_face(gmsh, face) for _, face in sides], size)


def crankshaft_among(
    path: str, solids: Sequence[SolidInFile], name: str | None, built_up: Callable[[], bool]
) -> int:
    """Find the crankshaft among the solids.

    Parameters
    ----------
    name : str or None
        Of a solid, with or without its number, or the number alone; by default the one crankshaft.
    built_up : callable
        Tells whether all solids together are one.

    Returns
    -------
    int
        Its place among them.

    Raises
    ------
    InputError
        If it is not one.
    """
    names = ", ".join(repr(solid.name) for solid in solids)
    places = range(len(solids))
    if name is not None:
        places_named = [
            place
            for place in places
            if name.strip() in (solids[place].name, *solids[place].name.split(" ", 1))
        ]
        if len(places_named) != 1:
            fault = "names no solid" if not places_named else f"names {len(places_named)} solids"
            raise InputError(
                f"solid: given {name!r}, which {fault}; allowed is one of {names}, or its number."
            )
        (place,) = places_named
        if solids[place].what:
            raise InputError(
                f"solid: given {name!r}, which is no crankshaft ({solids[place].what}); allowed is "
                "one with crankpins between main journals."
            )
        return place
    cranks = [place for place in places if not solids[place].what]
    if len(cranks) > 1:
        raise InputError(
            f"{path}: given {len(cranks)} crankshafts, "
            f"{', '.join(repr(solids[place].name) for place in cranks)}; allowed is one, or the name of "
            "one of them (solid, --solid)."
        )
    if not cranks:
        found = "; ".join(f"{solid.name}: {solid.what}" for solid in solids)
        if built_up():
            raise InputError(
                f"{path}: given a crankshaft built up of {len(solids)} solids ({found}); allowed is one "
                "that is one solid, so unite them in the CAD program."
            )
        raise InputError(
            f"{path}: given no crankshaft in one solid ({found}); allowed is one solid with crankpins "
            "between main journals."
        )
    return cranks[0]
