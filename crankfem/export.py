"""Write a throw's mesh with displacements for other programs."""

from pathlib import Path

from crankfem.pictures.surface import stretched_part
from fem.analysis import ThrowAnalysis


def write_vtu(analysis: ThrowAnalysis, path: str | Path) -> Path:
    """Write the solved mesh with its displacement under 1 N of axial pull, ends pinned.

    Parameters
    ----------
    analysis : ThrowAnalysis
    path : path
        File whose ending meshio knows, such as ``.vtu`` for ParaView.

    Returns
    -------
    Path
        The file.
    """
    import meshio

    mesh = meshio.Mesh(
        analysis.mesh.points,
        [("tetra10", analysis.mesh.elements)],
        point_data={"displacement": stretched_part(analysis)},
    )
    mesh.write(path)
    return Path(path)
