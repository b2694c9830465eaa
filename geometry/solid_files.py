"""Write the solid of a throw or of a whole crankshaft as STEP."""

from pathlib import Path

from geometry.crankshaft import Crankshaft, make_shaft
from geometry.errors import InputError, MeshError
from geometry.gmsh_session import gmsh_session
from geometry.isolated import ProcessLostError
from geometry.mesher import TIME_LIMIT, shared_process
from geometry.solid import make_solid, remove_loose
from geometry.throw import CrankThrow

ENDINGS = (".step", ".stp")


def write_step(solid: CrankThrow | Crankshaft, path: str | Path, part: str = "full") -> Path:
    """Write a solid as STEP (ISO 10303-21, AP 214), lengths in m.

    Parameters
    ----------
    solid : CrankThrow or Crankshaft
    path : path
        A file ending in ``.step`` or ``.stp``.
    part : {"full", "half", "quarter"}
        Of a throw; only what its symmetry allows.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is another, or the file cannot be written.
    MeshError
        If the kernel cannot build the solid.
    """
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed are {', '.join(ENDINGS)}."
        )
    try:
        text = shared_process().call(
            "geometry.solid_files:step_text", solid, part, time_limit=TIME_LIMIT
        )
    except ProcessLostError as error:
        raise MeshError(f"the solid could not be built: {error}.") from None
    try:
        path.write_text(text, encoding="ascii")
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error}).") from None
    return path


def step_text(solid: CrankThrow | Crankshaft, part: str) -> str:
    """Build a solid in this process and return its STEP file."""
    import tempfile

    with gmsh_session("export") as gmsh, tempfile.TemporaryDirectory() as folder:
        if isinstance(solid, CrankThrow):
            make_solid(gmsh, solid.parts, part)
        else:
            make_shaft(gmsh, solid)
        remove_loose(gmsh)
        file = Path(folder) / "solid.step"
        gmsh.write(str(file))
        text = file.read_text(encoding="ascii")
    # gmsh writes the numbers as they are, in m, and says that they are mm.
    return text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)")
