"""STEP files of crankshafts as CAD writes them: turned, in inches, beside other parts, faces divided."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crankbase.processes import scratch_folder
from geometry.crankshaft import make_shaft
from geometry.gmsh_session import gmsh_session

MILLIMETER = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )"
INCH = (
    "(CONVERSION_BASED_UNIT('INCH',#900002) LENGTH_UNIT() NAMED_UNIT(#900003))",
    f"#900001={MILLIMETER};\n#900002=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#900001);\n"
    "#900003=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n",
)
UNITS = {"mm": (1e-3, MILLIMETER, ""), "inch": (0.0254, *INCH)}


@dataclass(frozen=True)
class Posture:
    """How a crankshaft lies in a file.

    Attributes
    ----------
    turn : (3,) tuple
        Rotation vector [rad].
    shift : (3,) tuple
        [m]
    unit : str
        One of `UNITS`.
    beside : bool
        Whether a rod, a piston and a camshaft are in the file, too.
    divided, splines : bool
        Whether faces are divided along a plane through the axis, or are exact splines.
    """

    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    unit: str = "mm"
    beside: bool = False
    divided: bool = False
    splines: bool = False


def write_parts(path, build, posture=Posture()):
    """Write what a function builds in gmsh, in m, as a STEP file."""
    size, entity, more = UNITS[posture.unit]
    with gmsh_session("write") as gmsh, scratch_folder() as folder:
        occ = gmsh.model.occ
        build(gmsh)
        occ.synchronize()
        gmsh.write(str(folder / "shaft.brep"))
        gmsh.model.remove()
        gmsh.model.add("scaled")
        gmsh.option.setNumber("Geometry.OCCScaling", 1.0 / size)
        solids = [made for made in occ.importShapes(str(folder / "shaft.brep")) if made[0] == 3]
        gmsh.option.setNumber("Geometry.OCCScaling", 1.0)
        if posture.divided:
            solids = divide(gmsh, solids)
        angle = math.hypot(*posture.turn)
        if angle:
            occ.rotate(solids, 0, 0, 0, *(part / angle for part in posture.turn), angle)
        occ.translate(solids, *(part / size for part in posture.shift))
        if posture.splines:
            occ.affineTransform(solids, np.eye(4)[:3].ravel().tolist())
        if posture.beside:
            occ.synchronize()
            put_beside(gmsh, gmsh.model.getBoundingBox(-1, -1))
        occ.synchronize()
        gmsh.write(str(folder / "parts.step"))
        text = (folder / "parts.step").read_text(encoding="utf-8")
    assert MILLIMETER in text
    text = text.replace(MILLIMETER, entity).replace("ENDSEC;\nEND-", f"{more}ENDSEC;\nEND-")
    Path(path).write_text(text, encoding="utf-8")
    return Path(path)


def write_shaft(path, shaft, posture=Posture()):
    """Write a `Crankshaft` as a STEP file."""
    return write_parts(path, lambda gmsh: make_shaft(gmsh, shaft), posture)


def divide(gmsh, solids):
    """Divide the faces of solids along the plane x = 0, as programs do that revolve halves."""
    occ = gmsh.model.occ
    occ.synchronize()
    box = gmsh.model.getBoundingBox(-1, -1)
    reach = 2.0 * max(map(abs, box))
    plane = occ.addRectangle(-reach, -reach, 0.0, 2.0 * reach, 2.0 * reach)
    occ.rotate([(2, plane)], 0, 0, 0, 0, 1, 0, math.pi / 2.0)
    _, (halves, *_) = occ.fragment(solids, [(2, plane)])
    halves = [half for half in halves if half[0] == 3]
    occ.remove([(2, tag) for _, tag in occ.getEntities(2)], recursive=False)
    gmsh.option.setNumber("Geometry.OCCUnionUnify", 0)
    whole, _ = occ.fuse(halves[:1], halves[1:])
    gmsh.option.setNumber("Geometry.OCCUnionUnify", 1)
    return whole


def put_beside(gmsh, box):
    """Add a rod, a piston and a camshaft beside what is there."""
    occ = gmsh.model.occ
    size = max(box[3] - box[0], box[4] - box[1], box[5] - box[2])
    x, y, z = box[3] + 0.3 * size, box[1], box[2]
    make_rod(gmsh, (x, y, z), size)
    occ.addCylinder(x, y + 0.6 * size, z, 0.0, 0.1 * size, 0.0, 0.06 * size)
    make_camshaft(gmsh, (x + 0.3 * size, y, z), size)


def make_rod(gmsh, place, size):
    """Add a connecting rod."""
    occ = gmsh.model.occ
    x, y, z = place
    big = (3, occ.addCylinder(x, y, z, 0.0, 0.0, 0.05 * size, 0.08 * size))
    small = (3, occ.addCylinder(x, y + 0.3 * size, z, 0.0, 0.0, 0.05 * size, 0.05 * size))
    shank = (3, occ.addBox(x - 0.02 * size, y, z, 0.04 * size, 0.3 * size, 0.05 * size))
    body, _ = occ.fuse([big], [small, shank])
    eyes = [
        (3, occ.addCylinder(x, y, z - size, 0.0, 0.0, 3.0 * size, 0.06 * size)),
        (3, occ.addCylinder(x, y + 0.3 * size, z - size, 0.0, 0.0, 3.0 * size, 0.03 * size)),
    ]
    occ.cut(body, eyes)


def make_camshaft(gmsh, place, size):
    """Add a camshaft with four round eccentrics."""
    occ = gmsh.model.occ
    x, y, z = place
    shaft = (3, occ.addCylinder(x, y, z, 0.0, 0.0, size, 0.02 * size))
    cams = []
    for number in range(4):
        angle = 0.5 * math.pi * number
        at = (x + 0.01 * size * math.cos(angle), y + 0.01 * size * math.sin(angle))
        along = z + (0.15 + 0.2 * number) * size
        cams.append((3, occ.addCylinder(*at, along, 0.0, 0.0, 0.05 * size, 0.035 * size)))
    occ.fuse([shaft], cams)
