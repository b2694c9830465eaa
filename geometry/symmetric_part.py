"""The quarter or half of a CAD throw that stands for the whole, cut out of its solid."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from crankbase.errors import MeshError
from geometry.gmsh_session import gmsh_errors
from geometry.mass import solid_mass_properties
from geometry.mesh import SolidProperties
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE, RIGHT_END, Zone, remove_loose
from geometry.surface_mass import measured_properties

# Mass, center and inertia of the mirrored part are the whole's to this share of mass and length.
MIRRORED = 1e-5
# The planes reach so many lengths of the throw to all sides.
FAR = 10.0
Key = TypeVar("Key")
# Surfaces or curves by what they are.
Named = Sequence[tuple[Key, Sequence[int]]]


@dataclass(frozen=True)
class PartOfSolid:
    """What is to be meshed, alone in the current gmsh model.

    Attributes
    ----------
    solid : SolidProperties
    surfaces : dict
        Surface tags by surface name, those of the cuts too.
    fillets, corners : dict
        Tags of surfaces and curves of `ImportedThrow.fillets` and `corners`.
    """

    solid: SolidProperties
    surfaces: dict[str, list[int]]
    fillets: dict[Zone, list[int]]
    corners: dict[Zone, list[int]]


def part_of_solid(
    gmsh: Any,
    tag: int,
    part: str,
    length: float,
    surfaces: Named[str],
    fillets: Named[Zone],
    corners: Named[Zone],
) -> PartOfSolid:
    """Cut a throw's solid by its planes of symmetry, and keep the side x > 0, z < length / 2.

    Parameters
    ----------
    gmsh : module
        With the solid of this tag alone, in the throw frame.
    part : {"quarter", "half", "full"}
        What to keep.
    length : float
        Of the throw.
    surfaces, fillets, corners : sequences of pairs
        Tags in the whole solid.

    Raises
    ------
    MeshError
        If the kernel fails, or the part mirrored is not the whole.
    """
    whole = measured_properties(gmsh, tag)
    if part == "full":
        return PartOfSolid(whole, _listed(surfaces), _listed(fillets), _listed(corners))
    occ = gmsh.model.occ
    with gmsh_errors("cut the throw by its planes of symmetry"):
        planes = [_plane(gmsh, length, (0.0, 1.0, 0.0), 0.0)]
        if part == "quarter":
            planes.append(_plane(gmsh, length, None, length / 2.0))
        before = [(3, tag), *_entities(2, surfaces), *_entities(1, corners)]
        # Those before are kept: gmsh would number faces that no plane divides like others.
        _, images = occ.fragment(before, planes, removeObject=False, removeTool=False)
        pieces = [piece for dimension, piece in images[0] if dimension == 3]
        wanted = []
        for piece in pieces:
            x, _, z = occ.getCenterOfMass(3, piece)
            if x > 0.0 and (part == "half" or z < length / 2.0):
                wanted.append(piece)
        if len(wanted) != 1:
            raise MeshError(f"planes of symmetry leave {len(wanted)} pieces of the throw.")
        others = {tag, *pieces} - {*wanted}
        occ.remove([(3, other) for other in sorted(others)], recursive=True)
        occ.remove(planes, recursive=True)
        remove_loose(gmsh)
        solid = measured_properties(gmsh, wanted[0])
        sides = gmsh.model.getBoundary([(3, wanted[0])], combined=False, oriented=False)
        edges = gmsh.model.getBoundary(sides, combined=False, oriented=False)
        here = {*sides, *edges}
        became = {
            old: [new for _, new in image if (old[0], new) in here]
            for old, image in zip(before, images, strict=False)
        }
    mirrored = solid_mass_properties(solid, part, length, 1.0)
    uncut = solid_mass_properties(whole, "full", length, 1.0)
    off = (
        abs(mirrored.mass / uncut.mass - 1.0),
        float(np.abs(mirrored.center - uncut.center).max()) / length,
        float(np.abs(mirrored.inertia - uncut.inertia).max()) / (uncut.mass * length**2),
    )
    if max(off) > MIRRORED:
        raise MeshError(
            f"a {part} of the throw, mirrored, differs from the whole by {max(off):.2g} of its mass."
        )

    def renamed(dimension: int, named: Named[Key]) -> dict[Key, list[int]]:
        every = {
            name: sorted({new for old in tags for new in became[dimension, old]})
            for name, tags in named
        }
        return {name: tags for name, tags in every.items() if tags}

    kept = renamed(2, surfaces)
    known = {new for tags in kept.values() for new in tags}
    cuts = [new for _, new in sides if new not in known]
    across = [new for new in cuts if occ.getCenterOfMass(2, new)[0] < 1e-6 * length]
    kept[CRANK_PLANE] = across
    if part == "quarter":
        kept[MIDDLE_PLANE] = [new for new in cuts if new not in across]
        kept.pop(RIGHT_END, None)
    elif len(across) < len(cuts):
        raise MeshError("the planes of symmetry leave a face of unknown origin.")
    if not all(kept[cut] for cut in kept):
        raise MeshError("a cut by a plane of symmetry has no face.")
    return PartOfSolid(solid, kept, renamed(2, fillets), renamed(1, corners))


def _listed(named: Named[Key]) -> dict[Key, list[int]]:
    return {name: list(tags) for name, tags in named}


def _entities(dimension: int, named: Named[Key]) -> list[tuple[int, int]]:
    return sorted({(dimension, tag) for _, tags in named for tag in tags})


def _plane(
    gmsh: Any, length: float, turned: tuple[float, float, float] | None, place: float
) -> tuple[int, int]:
    """A square across z at a place, or through the shaft axis turned about another one."""
    occ, far = gmsh.model.occ, FAR * length
    plane = (2, int(occ.addRectangle(-far, -far, place, 2.0 * far, 2.0 * far)))
    if turned is not None:
        occ.rotate([plane], 0.0, 0.0, 0.0, *turned, math.pi / 2.0)
    return plane
