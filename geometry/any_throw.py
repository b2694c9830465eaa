"""A throw: one of dimensions, or a part whose shape is in a file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from crankbase.errors import InputError
from geometry.parts import Cylinder, ThrowParts
from geometry.throw import CrankThrow

if TYPE_CHECKING:  # files are read without a mesher
    from geometry.mesh import OnRemark, SolidProperties, ThrowMesh
    from geometry.sizes import SizeMap


@runtime_checkable
class CadPart(Protocol):
    """A throw whose shape is in a file; `geometry.imported.ImportedThrow` describes its attributes."""

    @property
    def path(self) -> str:
        """The file."""

    @property
    def digest(self) -> str:
        """SHA-256 of its content."""

    @property
    def length(self) -> float:
        """Distance of the end planes [m]."""

    @property
    def filleted(self) -> bool:
        """Whether no journal or pin meets a web in a sharp corner."""

    @property
    def fillets(self) -> Sequence[object]:
        """Those at its journals and pins."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """How it was understood."""

    @property
    def symmetry(self) -> str:
        """The part that is meshed."""

    @property
    def cylinders(self) -> tuple[Cylinder, ...]:
        """Left main journal, pins, right main journal."""

    @property
    def pin_axes(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the pins' axes [m]."""

    @property
    def parts(self) -> ThrowParts:
        """Journals and pins, without webs."""

    @property
    def solid(self) -> "SolidProperties":
        """In the throw frame."""

    @property
    def volume(self) -> float:
        """Of the solid [m^3]."""

    def read_into(self, gmsh: Any) -> tuple[int, int]:
        """Read its solid into the current gmsh model, in the throw frame."""

    @property
    def crank_radius(self) -> float:
        """Of the first pin [m]."""

    @property
    def pin_diameter(self) -> float:
        """Of the first pin [m]."""

    @property
    def pin_length(self) -> float:
        """Of the first pin [m]."""

    @property
    def pin_bore(self) -> float:
        """Of the first pin [m]."""

    @property
    def main_journal_diameter(self) -> float:
        """Of the thinner one [m]."""

    @property
    def main_journal_length(self) -> float:
        """Both halves [m]."""

    @property
    def main_journal_bore(self) -> float:
        """Of the larger one [m]."""

    def expected_unknowns(self, factor: float, part: str = "auto") -> int:
        """Predict the number of unknowns."""

    def meshed(
        self,
        size_factor: float = 1.0,
        part: str = "auto",
        sizes: "SizeMap | None" = None,
        attempts: tuple[str, ...] = (),
        on_remark: "OnRemark | None" = None,
    ) -> "ThrowMesh":
        """Mesh it in this process, as `mesh_throw` does."""

    def parts_by(self, mesh: "ThrowMesh") -> ThrowParts:
        """Return journals, pins and webs, measured on a mesh."""


Throw = CrankThrow | CadPart


# Why rules, formulas and drawings refuse a throw from CAD.
NO_DIMENSIONS = "a STEP file gives none"


def dimensioned(throws: Mapping[str, Throw]) -> dict[str, CrankThrow]:
    """Return the throws with dimensions: rules and formulas take no others."""
    return {name: throw for name, throw in throws.items() if isinstance(throw, CrankThrow)}


def with_dimensions(throw: Throw) -> CrankThrow:
    """Return a throw with dimensions; `InputError` for one from a STEP file."""
    if isinstance(throw, CrankThrow):
        return throw
    raise InputError(
        f"throw: given that of {Path(throw.path).name}; allowed is one of dimensions, because "
        f"{NO_DIMENSIONS}."
    )
