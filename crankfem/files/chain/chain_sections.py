"""The sections of chain files: every field with its unit, range and meaning, declared once.

Torsional and axial chains have the same fields in other units; a field whose unit differs is
declared for both.
"""

from typing import Any, ClassVar, Literal

from pydantic import Field

from crankbase.model import InputModel, part_field, quantity_field
from crankfem.files.sections.damper_sections import AxialDamperPart, TorsionalDamperPart

Numbers = float | tuple[float, ...]


UNITS = {
    "torsional": {"inertia": "kg m^2", "stiffness": "N m/rad", "damping": "N m s/rad"},
    "axial": {"inertia": "kg", "stiffness": "N/m", "damping": "N s/m"},
}
TORSIONAL_UNITS, AXIAL_UNITS = UNITS["torsional"], UNITS["axial"]


def _quantity(meaning: str, units: dict[str, str], kind: str, default: Any = 0.0) -> Any:
    # What need not be there may be zero; the rest is checked where it is used, to be above zero.
    return quantity_field(
        meaning,
        units[kind],
        minimum=0.0 if default == 0.0 else None,
        default=default,
        feature=default is not ...,
    )


def _pair() -> Any:
    return Field(
        None,
        description="names of the two nodes that it joins; for the element of number k from 0, by default "
        "nodes k and k + 1",
    )


def _loss_factor() -> Any:
    return quantity_field(
        "loss factor, hysteretic damping", "", 0.0, 2.0, default=0.0, feature=True
    )


class _Shape(InputModel):
    """Fields of an element that is a piece of shaft of classical shape."""

    nodes: tuple[str, str] | None = _pair()
    loss_factor: float = _loss_factor()
    shape: Literal["cylinder", "cone", "flange"] | None = Field(
        None, description="cylinder, cone or flange, in place of stiffness and inertia"
    )
    length: float | None = quantity_field("length, thickness of a flange", "m", default=None)
    diameter: float | None = quantity_field("outer diameter", "m", default=None)
    left_diameter: float | None = quantity_field(
        "outer diameter of a cone at its first node", "m", default=None
    )
    right_diameter: float | None = quantity_field(
        "outer diameter of a cone at its second node", "m", default=None
    )
    bore: float = quantity_field(
        "diameter of the bore, of a proportional one at the first node",
        "m",
        minimum=0.0,
        default=0.0,
        feature=True,
    )
    bore_shape: Literal["cylindrical", "proportional"] = Field(
        "cylindrical",
        description="of a cone: cylindrical, or a constant share of its diameter",
        json_schema_extra={"feature": True},
    )
    parts: int = quantity_field(
        "number of elements it is divided into", "", 1, 1000, default=1, feature=True
    )


class TorsionalNode(InputModel):
    """An inertia of a torsional chain."""

    name: str = Field(description="of the node")
    inertia: float = _quantity("moment of inertia", TORSIONAL_UNITS, "inertia", 0.0)
    entrained_share: float = quantity_field(
        "share added by entrained water", "", minimum=0.0, default=0.0, feature=True
    )
    ground_stiffness: float = _quantity("stiffness to ground", TORSIONAL_UNITS, "stiffness")
    ground_damping: float = _quantity("absolute damping", TORSIONAL_UNITS, "damping")


class AxialNode(InputModel):
    """A mass of an axial chain."""

    name: str = Field(description="of the node")
    mass: float = _quantity("mass", AXIAL_UNITS, "inertia", 0.0)
    entrained_share: float = quantity_field(
        "share added by entrained water", "", minimum=0.0, default=0.0, feature=True
    )
    ground_stiffness: float = _quantity("stiffness to ground", AXIAL_UNITS, "stiffness")
    ground_damping: float = _quantity("absolute damping", AXIAL_UNITS, "damping")


class TorsionalElement(_Shape):
    """A spring of a torsional chain, or a piece of shaft."""

    stiffness: float | None = _quantity("stiffness", TORSIONAL_UNITS, "stiffness", None)
    damping: float = _quantity("relative damping", TORSIONAL_UNITS, "damping")
    distributed_inertia: float = _quantity(
        "inertia spread evenly along it", TORSIONAL_UNITS, "inertia"
    )


class AxialElement(_Shape):
    """A spring of an axial chain, or a piece of shaft."""

    stiffness: float | None = _quantity("stiffness", AXIAL_UNITS, "stiffness", None)
    damping: float = _quantity("relative damping", AXIAL_UNITS, "damping")
    distributed_inertia: float = _quantity("mass spread evenly along it", AXIAL_UNITS, "inertia")


class GearPair(InputModel):
    """A rigid speed ratio between two nodes."""

    driver: str = Field(description="name of the driving node")
    driven: str = Field(description="name of the driven node")
    ratio: float = quantity_field(
        "speed of the driven node per speed of the driver, negative where the sense changes", ""
    )


class TorsionalDashpot(InputModel):
    """Viscous damping between two nodes of a torsional chain without a spring."""

    nodes: tuple[str, str] = Field(description="names of the two nodes")
    damping: float = _quantity("torque per relative speed", TORSIONAL_UNITS, "damping", ...)


class AxialDashpot(InputModel):
    """Viscous damping between two nodes of an axial chain without a spring."""

    nodes: tuple[str, str] = Field(description="names of the two nodes")
    damping: float = _quantity("force per relative speed", AXIAL_UNITS, "damping", ...)


class _ChainSection(InputModel):
    """Common fields of torsional and axial chains."""

    section: ClassVar[str] = "chain"

    name: str = Field(description="name of the chain")
    names: tuple[str, ...] | None = Field(
        None, description="names of the nodes of a list of inertias or masses"
    )
    loss_factor: Numbers = quantity_field(
        "loss factor of each value of stiffness, or of all", "", default=0.0, feature=True
    )
    gears: tuple[GearPair, ...] = part_field("gears", GearPair, many=True)


class TorsionalChainSection(_ChainSection):
    """A torsional chain."""

    kind: Literal["torsional"] = Field(description="torsional or axial")
    inertia: tuple[float, ...] | None = quantity_field(
        "inertias in a row, in place of nodes", TORSIONAL_UNITS["inertia"], default=None
    )
    stiffness: tuple[float, ...] | None = quantity_field(
        "stiffness between neighbors, in place of elements",
        TORSIONAL_UNITS["stiffness"],
        default=None,
    )
    damping: Numbers = quantity_field(
        "relative damping of each value of stiffness, or of all",
        TORSIONAL_UNITS["damping"],
        default=0.0,
        feature=True,
    )
    ground_stiffness: tuple[float, ...] | None = quantity_field(
        "stiffness of each node of the list to ground", TORSIONAL_UNITS["stiffness"], default=None
    )
    ground_damping: tuple[float, ...] | None = quantity_field(
        "absolute damping of each node of the list", TORSIONAL_UNITS["damping"], default=None
    )
    nodes: tuple[TorsionalNode, ...] = part_field("nodes", TorsionalNode, many=True)
    elements: tuple[TorsionalElement, ...] = part_field("elements", TorsionalElement, many=True)
    dashpots: tuple[TorsionalDashpot, ...] = part_field("dashpots", TorsionalDashpot, many=True)
    dampers: tuple[TorsionalDamperPart, ...] = part_field("dampers", TorsionalDamperPart, many=True)


class AxialChainSection(_ChainSection):
    """An axial chain."""

    kind: Literal["axial"] = Field(description="torsional or axial")
    mass: tuple[float, ...] | None = quantity_field(
        "masses in a row, in place of nodes", AXIAL_UNITS["inertia"], default=None
    )
    stiffness: tuple[float, ...] | None = quantity_field(
        "stiffness between neighbors, in place of elements", AXIAL_UNITS["stiffness"], default=None
    )
    damping: Numbers = quantity_field(
        "relative damping of each value of stiffness, or of all",
        AXIAL_UNITS["damping"],
        default=0.0,
        feature=True,
    )
    ground_stiffness: tuple[float, ...] | None = quantity_field(
        "stiffness of each node of the list to ground", AXIAL_UNITS["stiffness"], default=None
    )
    ground_damping: tuple[float, ...] | None = quantity_field(
        "absolute damping of each node of the list", AXIAL_UNITS["damping"], default=None
    )
    nodes: tuple[AxialNode, ...] = part_field("nodes", AxialNode, many=True)
    elements: tuple[AxialElement, ...] = part_field("elements", AxialElement, many=True)
    dashpots: tuple[AxialDashpot, ...] = part_field("dashpots", AxialDashpot, many=True)
    dampers: tuple[AxialDamperPart, ...] = part_field("dampers", AxialDamperPart, many=True)
