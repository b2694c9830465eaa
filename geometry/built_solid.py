"""The solid of a throw in gmsh, kept by a process for the next mesh of the same throw.

It is built with the main journal's diameter as the unit of length. The kernel's tolerances are lengths: so
they are the same share of every throw, and throws that differ by their size alone get the same mesh.
"""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from geometry.gmsh_session import gmsh_session, load_gmsh
from geometry.mesh_checks import SolidProperties, check_solid, solid_properties
from geometry.parts import ThrowParts, scaled_parts
from geometry.solid import build_solid, part_end

Options = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class BuiltSolid:
    """A throw, or the part of it required by its symmetry, in the current gmsh model.

    Attributes
    ----------
    gmsh : module
    unit : float
        Length of 1 in the model [m].
    parts : ThrowParts
        The parts of the model, in its unit.
    last : float
        Where it ends along z.
    surfaces : dict
        Surface tags by surface name.
    solid : SolidProperties
        In SI units.
    seconds : float
        Time to build it, 0 if it was kept.
    """

    gmsh: Any
    unit: float
    parts: ThrowParts
    last: float
    surfaces: dict[str, list[int]]
    solid: SolidProperties
    seconds: float


class SolidKeeper:
    """Opens solids, one at a time, and keeps the last one open if told to.

    Attributes
    ----------
    keeps : bool
        Whether it does; by default, nothing stays open.
    """

    def __init__(self) -> None:
        self.keeps = False
        self._session = ExitStack()
        self._key: tuple[ThrowParts, str, Options] | None = None
        self._gmsh: Any = None
        self._surfaces: dict[str, list[int]]
        self._solid: SolidProperties

    def close(self) -> None:
        """Release the kept solid."""
        self._key = None
        self._session.close()

    @contextmanager
    def opened(self, parts: ThrowParts, part: str, options: Options = ()) -> Iterator[BuiltSolid]:
        """Open the solid of a part of a throw, built with options of gmsh, its model without a mesh.

        Raises
        ------
        MeshError
            If the kernel lost a part, or did not unite all parts.
        """
        begin, seconds = time.perf_counter(), 0.0
        unit = 2.0 * parts.cylinders[0].radius
        key = (scaled_parts(parts, 1.0 / unit), part, options)
        try:
            if key != self._key:
                self.close()
                self._build(*key)
                check_solid(parts, part, self._solid.scaled(unit))
                self._key, seconds = key, time.perf_counter() - begin
            yield BuiltSolid(
                gmsh=self._gmsh,
                unit=unit,
                parts=key[0],
                last=part_end(key[0], part),
                surfaces=self._surfaces,
                solid=self._solid.scaled(unit),
                seconds=seconds,
            )
            if self.keeps:
                self._remove_mesh()
        except BaseException:
            self.close()
            raise
        if not self.keeps:
            self.close()

    def _build(self, parts: ThrowParts, part: str, options: Options) -> None:
        self._gmsh = self._session.enter_context(gmsh_session("throw"))
        for option, value in options:
            self._gmsh.option.setNumber(option, value)
        self._surfaces = build_solid(self._gmsh, parts, part)
        self._solid = solid_properties(self._gmsh)
        self._views = set(self._gmsh.view.getTags())

    def _remove_mesh(self) -> None:
        """Remove the mesh and its size fields."""
        self._gmsh.model.mesh.clear()
        for field in self._gmsh.model.mesh.field.list():
            self._gmsh.model.mesh.field.remove(field)
        for view in set(self._gmsh.view.getTags()) - self._views:
            self._gmsh.view.remove(view)


# Of this process, where it is one of ours that keeps a solid.
_KEEPER = SolidKeeper()


def keep_solids() -> None:
    """Let this process keep the solid it built last: for processes that use gmsh only for this.

    Raises
    ------
    MissingLibraryError
        If gmsh cannot be loaded.
    """
    load_gmsh()
    _KEEPER.keeps = True


@contextmanager
def built_solid(parts: ThrowParts, part: str, options: Options = ()) -> Iterator[BuiltSolid]:
    """Open a throw's solid for a while, as `SolidKeeper.opened` does, by what this process keeps if any."""
    with (_KEEPER if _KEEPER.keeps else SolidKeeper()).opened(parts, part, options) as built:
        yield built
