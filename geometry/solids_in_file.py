"""The solids of a CAD file, and the crankshaft among them."""

import math
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np

from crankbase.errors import InputError
from crankbase.results import Quantity, Result, result
from geometry.faces import measured_face
from geometry.shaft_shape import Line, crank_line

# The kernel's tolerances are made for lengths in mm, in which it reads files.
MM = 1e-3
# A box within a pin, relative to its radius, and where it may be beside a bore.
SMALL, SHARES = 0.01, (0.6, 0.75, 0.9)
# A union keeps the volume to this share.
UNITED = 1e-4
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


def united(gmsh: Any, solid: int, line: Line) -> tuple[int, Line]:
    """Unite the faces of a crankshaft that are divided, as by programs that revolve halves.

    The kernel does so with the result of a union: here with a small box within a pin.

    Returns
    -------
    tuple of (int, Line)
        The solid and its axis; the ones given, if journals and pins are in one piece.
    """
    if all(len(item.tags) == 1 for item in (*line.rounds, *line.pins)):
        return solid, line
    occ, pin = gmsh.model.occ, line.pins[0]
    size = SMALL * pin.radius
    for share in (0.0, *SHARES):
        middle = np.array([pin.axis[0] + share * pin.radius, pin.axis[1], pin.middle])
        place = line.rotation.T @ middle
        if gmsh.model.isInside(3, solid, place.tolist()):
            break
    box = (3, occ.addBox(*(place - 0.5 * size).tolist(), size, size, size))
    made, _ = occ.fuse(occ.copy([(3, solid)]), [box])
    occ.synchronize()
    (_, whole), *others = made
    volumes = float(occ.getMass(3, whole)), float(occ.getMass(3, solid))
    new = _line(gmsh, whole) if not others and math.isclose(*volumes, rel_tol=UNITED) else ""
    if isinstance(new, str):
        occ.remove(made, recursive=True)
        return solid, line
    occ.remove([(3, solid)], recursive=True)
    occ.synchronize()
    return whole, new


def _line(gmsh: Any, tag: int) -> Line | str:
    box = gmsh.model.getBoundingBox(3, tag)
    sides = gmsh.model.getBoundary([(3, tag)], combined=False, oriented=False)
    faces = [measured_face(gmsh, face) for _, face in sides]
    return crank_line(faces, math.dist(box[:3], box[3:]))


def crankshaft_among(path: str, solids: Sequence[SolidInFile], name: str | None) -> int:
    """Find the crankshaft among the solids.

    Parameters
    ----------
    name : str or None
        Of a solid, with or without its number, or the number alone; by default the one crankshaft.

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
        built = ", or built up of several solids" if len(solids) > 1 else ""
        raise InputError(
            f"{path}: given no crankshaft in one solid ({found}); allowed is one solid with crankpins "
            f"between main journals, not a part of one{built}."
        )
    return cranks[0]
