"""Write a throw's mesh with displacements for other programs."""

from pathlib import Path

from crankfem.analyses.throw.pictures.surface import stretched_part
from fem.throw_analysis import ThrowAnalysis
from geometry.mesh_files import write_mesh


def write_vtu(analysis: ThrowAnalysis, path: str | Path) -> Path:
    """Write the solved mesh with its displacement under 1 N of axial pull, ends pinned.

    Parameters
    ----------
    analysis : ThrowAnalysis
    path : path
        File ending in ``.vtu`` or another format of `write_mesh` that carries values at nodes.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written.
    """
    return write_mesh(analysis.mesh, path, {"displacement": stretched_part(analysis)})
