"""Pictures of a throw's or a crankshaft's solid, seen from the side with the free end to the left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array, Integers
from crankbase.errors import InputError
from crankbase.outputs import copy_picture
from crankbase.processes import scratch_folder
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.analyses.throw.pictures.stress_picture import (
    outside_corners,
    outside_facets,
)
from crankfem.analyses.throw.pictures.stress_rendering import Scene
from fem.whole_throw import whole_facets, whole_nodes, whole_points
from geometry.any_throw import Throw
from geometry.crankshaft import Crankshaft
from geometry.mesher import mesh_isolated
from geometry.solid import BORE, COUNTERWEIGHT, FILLET, LEFT_END, RIGHT_END, WEB

Numbers = Integers

# Kinds of surfaces that a picture tells apart.
MACHINED, FORGED, FILLETS, BORES, ENDS, FIRST_THROW = range(6)
# Of throws that are told apart, neighbors differ.
THROW_COLORS = ("#8fb4d9", "#e8b878", "#9cc79a", "#d99a94", "#b7a6d6", "#b9b48a")
KINDS = {
    WEB: FORGED,
    COUNTERWEIGHT: FORGED,
    FILLET: FILLETS,
    BORE: BORES,
    LEFT_END: ENDS,
    RIGHT_END: ENDS,
}
CYLINDER_SIDES = 180
# Finer than for computing: elements whose edges were straightened leave smaller dents.
SIZE_FACTOR = 0.7


@dataclass(frozen=True)
class SolidSurface:
    """Triangles of a solid's outside, counterclockwise from outside.

    Attributes
    ----------
    points : (n, 3) array
        [m]; neighboring triangles have separate points at the same position.
    triangles : (t, 3) array
    kinds : (t,) array
        Kind of each triangle, `MACHINED` and so on.
    """

    points: Array
    triangles: Numbers
    kinds: Numbers

    def moved(self, angle: float, shift: float) -> "SolidSurface":
        """Turn about +z [rad], then move along z [m]."""
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        return replace(self, points=self.points @ turn.T + np.array([0.0, 0.0, shift]))

    def without_ends(self, z: Sequence[float]) -> "SolidSurface":
        """Leave out the ends of throws at some positions along the shaft [m]."""
        places = self.points[self.triangles[:, 0], 2]
        tolerance = 1e-9 * float(np.ptp(self.points[:, 2]))
        inner = np.any(np.abs(places[:, None] - np.array(z)) < tolerance, axis=1)
        kept = ~(inner & (self.kinds == ENDS))
        return replace(self, triangles=self.triangles[kept], kinds=self.kinds[kept])


def throw_surface(throw: Throw, fineness: int) -> SolidSurface:
    """Surface of a whole throw, mirrored from the meshed part.

    Parameters
    ----------
    fineness : int
        Each curved triangle of the mesh becomes the square of this number of flat ones.

    Raises
    ------
    MeshError
        If the throw cannot be meshed.
    """
    mesh = mesh_isolated(throw, SIZE_FACTOR)
    whole = whole_nodes(mesh)
    facets = whole_facets(whole, outside_facets(mesh))
    kinds = [
        np.full(len(corners), KINDS.get(name, MACHINED))
        for name, corners in outside_corners(mesh).items()
    ]
    weights, pieces = _subdivision(fineness)
    starts = len(weights) * np.arange(len(facets))
    return SolidSurface(
        np.einsum("pi,tix->tpx", weights, whole_points(mesh, whole)[facets]).reshape(-1, 3),
        (starts[:, None, None] + pieces).reshape(-1, 3),
        np.tile(np.repeat(np.concatenate(kinds), len(pieces)), len(whole.images)),
    )


def shaft_surface(shaft: Crankshaft, fineness: int, colored: bool = False) -> SolidSurface:
    """Surface of a crankshaft: its throws at their angles, free end and flange.

    Parameters
    ----------
    fineness : int
        As for `throw_surface`.
    colored : bool
        Whether each throw is of a kind of its own.

    Raises
    ------
    MeshError
        If a throw cannot be meshed.
    """
    made = {throw: throw_surface(throw, fineness) for throw in set(shaft.throws)}
    row = [
        made[throw].moved(angle, float(start))
        for throw, angle, start in zip(
            shaft.throws, np.radians(shaft.crank_angles_deg), shaft.starts[:-1], strict=True
        )
    ]
    if colored:
        row = [
            replace(
                throw, kinds=np.full_like(throw.kinds, FIRST_THROW + number % len(THROW_COLORS))
            )
            for number, throw in enumerate(row)
        ]
    inside = enumerate(shaft.starts[1:-1].tolist())
    throws = _joined(row).without_ends([z for n, z in inside if shaft.bore_step(n) is None])
    return _joined([throws, *(cylinder_surface(*cylinder) for cylinder in shaft.end_cylinders)])


def _subdivision(count: int) -> tuple[Array, Numbers]:
    """Split a six-node triangle along lines that divide its sides evenly.

    Returns
    -------
    weights : (p, 6) array
        Weights of the nodes (corners 0 1 2, edge middles on 01 12 02) in each point.
    pieces : (count**2, 3) array
        The points of the flat triangles, in the same sense of rotation.
    """
    numbers = {
        (i, j): place
        for place, (i, j) in enumerate(
            (i, j) for i in range(count + 1) for j in range(count + 1 - i)
        )
    }
    pieces = []
    for i, j in numbers:
        if i + j < count:
            pieces.append([numbers[i, j], numbers[i + 1, j], numbers[i, j + 1]])
        if i + j < count - 1:
            pieces.append([numbers[i + 1, j], numbers[i + 1, j + 1], numbers[i, j + 1]])
    second, third = np.array(list(numbers)).T / count
    first = 1.0 - second - third
    shares = (first, second, third)
    at_corners = [share * (2.0 * share - 1.0) for share in shares]
    on_edges = [4.0 * shares[a] * shares[b] for a, b in ((0, 1), (1, 2), (0, 2))]
    return np.column_stack([*at_corners, *on_edges]), np.array(pieces)


def cylinder_surface(diameter: float, low: float, high: float) -> SolidSurface:
    """Surface of a cylinder about the shaft's axis."""
    angles = np.linspace(0.0, 2.0 * np.pi, CYLINDER_SIDES, endpoint=False)
    circle = 0.5 * diameter * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = [np.column_stack([circle, np.full(len(circle), z)]) for z in (low, high)]
    points = np.vstack([*ends, [[0.0, 0.0, low], [0.0, 0.0, high]]])
    first = np.arange(CYLINDER_SIDES)
    after = np.roll(first, -1)
    top, (low_center, high_center) = CYLINDER_SIDES, (2 * CYLINDER_SIDES, 2 * CYLINDER_SIDES + 1)
    triangles = np.vstack(
        [
            np.column_stack([first, after, after + top]),
            np.column_stack([first, after + top, first + top]),
            np.column_stack([after, first, np.full_like(first, low_center)]),
            np.column_stack([first + top, after + top, np.full_like(first, high_center)]),
        ]
    )
    return SolidSurface(points, triangles, np.full(len(triangles), MACHINED))


def _joined(surfaces: Sequence[SolidSurface]) -> SolidSurface:
    offsets = np.cumsum([0, *(len(surface.points) for surface in surfaces)])
    return SolidSurface(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate(
            [surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=False)]
        ),
        np.concatenate([surface.kinds for surface in surfaces]),
    )


ENDING = ".png"
PICTURE = "picture.png"  # in the scratch folder
COLORS = np.zeros((FIRST_THROW + len(THROW_COLORS), 3), dtype=np.uint8)
COLORS[FIRST_THROW:] = [list(bytes.fromhex(color[1:])) for color in THROW_COLORS]
COLORS[[MACHINED, ENDS]] = (208, 215, 222)
COLORS[FILLETS] = (196, 203, 211)
COLORS[FORGED] = (186, 195, 204)
COLORS[BORES] = (140, 150, 160)
# From the picture's middle to the eye.
THROW_VIEW, SHAFT_VIEW = (-1.0, 0.45, -0.6), (-1.0, 0.35, -0.45)
THROW_PIXELS, SHAFT_PIXELS = 1200, 2400  # along the longer side
SHADING: dict[str, Any] = {
    "ambient": 0.36,
    "diffuse": 0.85,
    "specular": 0.18,
    "specular_power": 25.0,
}


def picture_throw(throw: Throw, path: str | Path) -> Path:
    """Write a picture of a throw's solid.

    Parameters
    ----------
    path : path
        A file ending in ``.png``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written.
    MeshError
        If the throw cannot be meshed.
    MissingLibraryError, RenderError
        If there is no OpenGL library; the message names what to install.
    """
    path = Path(path)
    check_picture_ending(path)
    return _write(throw_surface(throw, fineness=4), THROW_VIEW, THROW_PIXELS, path)


def picture_shaft(shaft: Crankshaft, path: str | Path, *, colored: bool = False) -> Path:
    """Write a picture of a whole crankshaft.

    Parameters
    ----------
    path : path
        A file ending in ``.png``.
    colored : bool, optional
        Whether each throw has a color of its own.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, MeshError, MissingLibraryError, RenderError
        As for `picture_throw`.
    """
    path = Path(path)
    check_picture_ending(path)
    return _write(shaft_surface(shaft, 2, colored), SHAFT_VIEW, SHAFT_PIXELS, path)


def check_picture_ending(path: Path) -> None:
    """Refuse a file name that does not end in .png."""
    if path.suffix.lower() != ENDING:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed for a picture is {ENDING}."
        )


def _write(
    surface: SolidSurface, view: tuple[float, float, float], pixels: int, path: Path
) -> Path:
    with scratch_folder() as folder:
        OffscreenProcess(f"{__name__}:render", folder, surface, np.array(view), pixels).wait()
        try:
            copy_picture(folder / PICTURE, path)
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror or error}).") from None
    return path


def render(surface: SolidSurface, view: Array, pixels: int, folder: Path) -> None:
    """Render a solid in this process.

    Parameters
    ----------
    view : (3,) array
        From the picture's middle to the eye.
    pixels : int
        Of the picture's longer side.
    folder : Path
        Folder for the file `PICTURE`.
    """
    import pyvista
    from matplotlib.image import imsave

    scene = Scene(surface.points, view, pixels)
    solid = pyvista.PolyData(surface.points, np.insert(surface.triangles, 0, 3, axis=1).ravel())
    solid.cell_data["color"] = COLORS[surface.kinds]
    solid = solid.clean(tolerance=1e-6 * scene.longer, absolute=True)
    scene.add(solid, scalars="color", rgb=True, **SHADING)
    imsave(folder / PICTURE, scene.render())
    scene.close()
