"""Write the solid of a throw or of a whole crankshaft as STEP."""

import math
import re
from pathlib import Path

from crankbase.calls import ProcessLostError
from crankbase.errors import InputError, MeshError
from crankbase.outputs import write_errors, write_text
from crankbase.processes import scratch_folder
from geometry.crankshaft import Crankshaft, make_shaft
from geometry.gmsh_session import gmsh_errors, gmsh_session
from geometry.isolated import shared_process
from geometry.mesh import checked_part
from geometry.mesh_checks import check_solid, solid_properties
from geometry.mesher import TIME_LIMIT
from geometry.parts import ThrowParts
from geometry.solid import LEFT_END, RIGHT_END, make_solid, remove_loose
from geometry.step_file import CYLINDER, PLANE, StepFace, read_step
from geometry.throw import CrankThrow

ENDINGS = (".step", ".stp")


def write_step(solid: CrankThrow | Crankshaft, path: str | Path, part: str = "full") -> Path:
    """Write a solid as STEP (ISO 10303-21, AP 214), lengths in m.

    Faces of a throw's ends and pins are named "left end", "right end", "pin", "pin 2" ...

    Parameters
    ----------
    solid : CrankThrow or Crankshaft
    path : path
        A file ending in ``.step`` or ``.stp``.
    part : {"full", "half", "quarter", "auto"}
        Of a throw; only one that its symmetry allows.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, the throw lacks that symmetry, or the file cannot be written.
    MeshError
        If the kernel cannot build the solid.
    """
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed are {', '.join(ENDINGS)}."
        )
    if isinstance(solid, CrankThrow):
        part = checked_part(solid, part)
    elif part not in ("full", "auto"):
        raise InputError(
            f"part: given {part!r}; allowed is 'full', because a crankshaft is written whole."
        )
    try:
        text = shared_process().call(
            "geometry.solid_files:step_text", solid, part, time_limit=TIME_LIMIT
        )
    except ProcessLostError as error:
        raise MeshError(f"the solid could not be built: {error}.") from None
    with write_errors(path):
        return write_text(path, text, "solid")


def step_text(solid: CrankThrow | Crankshaft, part: str) -> str:
    """Build a solid in this process and return its STEP file."""
    with gmsh_session("export") as gmsh, scratch_folder() as folder:
        with gmsh_errors("build the solid"):
            if isinstance(solid, CrankThrow):
                make_solid(gmsh, solid.parts, part)
                remove_loose(gmsh)
                check_solid(solid.parts, part, solid_properties(gmsh))
            else:
                make_shaft(gmsh, solid)
            file = folder / "solid.step"
            gmsh.write(str(file))
        text = file.read_text(encoding="ascii")
    # gmsh writes the numbers as they are, in m, and says that they are mm.
    text = text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)")
    return _with_names(text, solid.parts) if isinstance(solid, CrankThrow) else text


def _with_names(text: str, parts: ThrowParts) -> str:
    """Name the end and pin faces, by which `import_throw` finds them; gmsh writes no names."""
    count = 0

    def numbered(_: re.Match[str]) -> str:
        nonlocal count
        count += 1
        return f"ADVANCED_FACE('face {count}'"

    text = re.sub(r"ADVANCED_FACE\(\s*''", numbered, text)
    for face in read_step(text.encode("ascii"), "the exported solid").faces:
        # Ends and pins are told apart by far more than the kernel's round-off.
        text = text.replace(f"'{face.name}'", f"'{_face_name(face, parts)}'", 1)
    return text


def _face_name(face: StepFace, parts: ThrowParts) -> str:
    x, y, z = face.point
    near = 1e-6 * parts.length
    if face.kind == PLANE and abs(face.axis[2]) > 0.999:
        ends = {LEFT_END: 0.0, RIGHT_END: parts.length}
        return next((name for name, place in ends.items() if abs(z - place) < near), "")
    if face.kind == CYLINDER:
        for pin in parts.pins:
            alike = math.dist((x, y), pin.axis) < near and abs(face.radius - pin.radius) < near
            low = min(corner[2] for corner in face.corners)
            if alike and pin.start - near < low < pin.end + near:
                return pin.name
    return ""
