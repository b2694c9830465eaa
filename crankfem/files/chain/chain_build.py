"""The sections of a chain file, and the chain that they make."""

import math
from collections.abc import Iterable
from copy import copy
from dataclasses import dataclass, replace
from types import GenericAlias
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import Field, create_model

from crankbase.array_checks import positive_number
from crankbase.choices import check_choice, so_many
from crankbase.errors import InputError, InputErrors
from crankbase.model import InputModel, field_extra, part_field, quantity_field
from crankfem.files.chain.maker_values import PerUnitBase, at_own_speeds, in_si
from crankfem.files.sections.vibration_sections import (
    AxialDamperPart,
    TorsionalDamperPart,
    part_quantity,
)
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.coupling_damping import (
    CONVENTIONS,
    LARGEST_PSI,
    MAGNIFIER,
    PSI,
    SMALLEST_MAGNIFIER,
)
from dynamics.chains.editing import with_damper
from dynamics.chains.shaft_line import ShaftCone, ShaftMaterial, shaft_cylinder, shaft_flange
from dynamics.chains.varying import Variation, Varying, VaryingPart, varied
from fem.material import Material

Numbers = float | tuple[float, ...]


# Units of what a chain is made of.
UNITS = {
    "torsional": {
        "inertia": "kg m^2",
        "stiffness": "N m/rad",
        "damping": "N m s/rad",
        "flexibility": "rad/(N m)",
    },
    "axial": {"inertia": "kg", "stiffness": "N/m", "damping": "N s/m", "flexibility": "m/N"},
}
INERTIA, STIFFNESS, DAMPING, FLEXIBILITY = UNITS["torsional"].values()
H = "H, energy at rated speed per rated power"
PER_UNIT = "rated torques per electrical radian"


@dataclass(frozen=True)
class Axial:
    """What a field of a torsional chain is in an axial one: its meaning, and its name if that is another."""

    meaning: str
    name: str | None = None


def _modulus(of: str) -> Any:
    return quantity_field(f"shear modulus of {of}", "Pa", 1e8, 3e11, default=None)


class _Varies(InputModel):
    """The field of nodes and elements whose spring and damper may vary."""

    variation: Variation | None = part_field("how stiffness and damping vary", Variation)


class Element(_Varies):
    """A spring of a torsional chain, or a piece of shaft."""

    nodes: tuple[str, str] | None = Field(
        None,
        description="names of the two nodes that it joins; for the element of number k from 0, by default "
        "nodes k and k + 1",
    )
    loss_factor: float = quantity_field(
        "loss factor, hysteretic damping", "", 0.0, 2.0, default=0.0, feature=True
    )
    relative_damping: float | None = quantity_field(PSI, "", 0.0, LARGEST_PSI, default=None)
    magnifier: float | None = quantity_field(MAGNIFIER, "", SMALLEST_MAGNIFIER, default=None)
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
    shear_modulus: Annotated[
        float | None,
        Axial("Young's modulus of the piece, by default that of the chain", "youngs_modulus"),
    ] = _modulus("the piece, by default that of the chain")
    parts: int = quantity_field(
        "number of elements it is divided into", "", 1, 1000, default=1, feature=True
    )
    stiffness: float | None = part_quantity("stiffness", STIFFNESS, None)
    flexibility: float | None = part_quantity("1 over the stiffness", FLEXIBILITY, None)
    per_unit_stiffness: float | None = part_quantity(PER_UNIT, "", None)
    damping: float = part_quantity("relative damping", DAMPING)
    distributed_inertia: Annotated[float, Axial("mass spread evenly along it")] = part_quantity(
        "inertia spread evenly along it", INERTIA
    )


class Node(_Varies):
    """An inertia of a torsional chain."""

    name: str = Field(description="of the node")
    inertia: Annotated[float, Axial("mass", "mass")] = part_quantity(
        "moment of inertia", INERTIA, 0.0
    )
    inertia_constant: float | None = quantity_field(H, "s", 0.0, default=None)
    entrained_share: float = quantity_field(
        "share added by entrained water", "", minimum=0.0, default=0.0, feature=True
    )
    ground_stiffness: float = part_quantity("stiffness to ground", STIFFNESS)
    ground_damping: float = part_quantity("absolute damping", DAMPING)


class GearPair(InputModel):
    """A rigid speed ratio between two nodes."""

    driver: str = Field(description="name of the driving node")
    driven: str = Field(description="name of the driven node")
    ratio: float = quantity_field(
        "speed of the driven node per speed of the driver, negative where the sense changes", ""
    )


class DashpotPart(InputModel):
    """Viscous damping between two nodes of a torsional chain without a spring."""

    nodes: tuple[str, str] = Field(description="names of the two nodes")
    damping: Annotated[float, Axial("force per relative speed")] = part_quantity(
        "torque per relative speed", DAMPING, ...
    )


class ChainSection(InputModel):
    """A torsional chain."""

    section: ClassVar[str] = "chain"

    name: str = Field(description="name of the chain")
    names: tuple[str, ...] | None = Field(
        None, description="names of the nodes of a list of inertias or masses"
    )
    loss_factor: Numbers = quantity_field(
        "loss factor of each value of stiffness, or of all", "", default=0.0, feature=True
    )
    relative_damping: Numbers | None = quantity_field(PSI, "", default=None)
    magnifier: Numbers | None = quantity_field(MAGNIFIER, "", default=None)
    shear_modulus: Annotated[
        float | None,
        Axial(
            "Young's modulus of all pieces of shaft, by default that of [material]",
            "youngs_modulus",
        ),
    ] = _modulus("all pieces of shaft, by default that of [material]")
    gears: tuple[GearPair, ...] = part_field("gears", GearPair, many=True)
    kind: Literal["torsional"] = Field(description="torsional or axial")
    inertia: Annotated[
        tuple[float, ...] | None, Axial("masses in a row, in place of nodes", "mass")
    ] = quantity_field("inertias in a row, in place of nodes", INERTIA, default=None)
    inertia_constant: tuple[float, ...] | None = quantity_field(H, "s", default=None)
    stiffness: tuple[float, ...] | None = quantity_field(
        "stiffness between neighbors, in place of elements", STIFFNESS, default=None
    )
    flexibility: tuple[float, ...] | None = quantity_field(
        "1 over the stiffness, 0 of a rigid joint or a gear", FLEXIBILITY, default=None
    )
    per_unit_stiffness: tuple[float, ...] | None = quantity_field(PER_UNIT, "", default=None)
    base: PerUnitBase | None = part_field("what values per unit are multiples of", PerUnitBase)
    referred_to: str | None = Field(
        None,
        description="name of the node at whose speed all values are; by default each is at its own",
    )
    damping: Numbers = quantity_field(
        "relative damping of each value of stiffness, or of all", DAMPING, default=0.0, feature=True
    )
    ground_stiffness: tuple[float, ...] | None = quantity_field(
        "stiffness of each node of the list to ground", STIFFNESS, default=None
    )
    ground_damping: tuple[float, ...] | None = quantity_field(
        "absolute damping of each node of the list", DAMPING, default=None
    )
    nodes: tuple[Node, ...] = part_field("nodes", Node, many=True)
    elements: tuple[Element, ...] = part_field("elements", Element, many=True)
    dashpots: tuple[DashpotPart, ...] = part_field("dashpots", DashpotPart, many=True)
    dampers: tuple[TorsionalDamperPart, ...] = part_field("dampers", TorsionalDamperPart, many=True)


TORSIONAL_ONLY = (
    "inertia_constant",
    "per_unit_stiffness",
    "base",
    "referred_to",
)


def _axial(model: type[InputModel], title: str, **kinds: Any) -> Any:
    """Return the axial kind of a model: its fields with their axial meanings, names and units.

    Parameters
    ----------
    **kinds
        Types of fields that differ.
    """
    units = dict(zip(UNITS["torsional"].values(), UNITS["axial"].values(), strict=True))
    fields: dict[str, Any] = {}
    for name, info in model.model_fields.items():
        if name in TORSIONAL_ONLY:
            continue
        field, axial_name = copy(info), name
        if (unit := field_extra(info, "unit")) in units:
            field.json_schema_extra = {**cast(Any, info.json_schema_extra), "unit": units[unit]}
        for axial in info.metadata:
            if isinstance(axial, Axial):
                field.description, axial_name = axial.meaning, axial.name or name
        fields[axial_name] = (kinds.get(name, info.annotation), field)
    made = create_model(f"Axial{model.__name__}", __base__=InputModel, **fields)
    made.section, made.__doc__ = model.section, title
    return made


@dataclass(frozen=True)
class ChainKind:
    """The models of a kind of chain, and what it calls its inertias and the modulus of a piece of shaft."""

    section: type[ChainSection]
    node: type[Node]
    element: type[Element]
    inertia: str
    modulus: str


def _axial_kind() -> ChainKind:
    node = _axial(Node, "A mass of an axial chain.")
    element = _axial(Element, "A spring of an axial chain, or a piece of shaft.")
    dashpot = _axial(
        DashpotPart, "Viscous damping between two nodes of an axial chain without a spring."
    )
    section = _axial(
        ChainSection,
        "An axial chain.",
        kind=Literal["axial"],
        nodes=GenericAlias(tuple, (node, ...)),
        elements=GenericAlias(tuple, (element, ...)),
        dashpots=GenericAlias(tuple, (dashpot, ...)),
        dampers=tuple[AxialDamperPart, ...],
    )
    return ChainKind(section, node, element, "mass", "youngs_modulus")


KINDS = {
    "torsional": ChainKind(ChainSection, Node, Element, "inertia", "shear_modulus"),
    "axial": _axial_kind(),
}
GROUND_FIELDS = ("ground_stiffness", "ground_damping")
# Fields of each shape; those of the others may not stand beside it.
SHAPES = {
    "cylinder": ("length", "diameter", "bore"),
    "flange": ("length", "diameter", "bore"),
    "cone": ("length", "left_diameter", "right_diameter", "bore", "bore_shape"),
}
SHAPE_FIELDS = ("length", "diameter", "left_diameter", "right_diameter", "bore", "bore_shape")


def shaft_row(
    section: ChainSection, material: Material
) -> tuple[tuple[str, ...], tuple[ShaftCone, ...]]:
    """Return the pieces of shaft that follow each other from the first node, and the names of their ends."""
    names = tuple(node.name for node in section.nodes)
    ends = [
        (element, *_ends(element, number, names)) for number, element in enumerate(section.elements)
    ]
    joints, pieces = list(names[:1]), list[ShaftCone]()
    while True:
        onward = [each for each in ends if joints[-1] == each[1]]
        if len(onward) != 1 or onward[0][0].shape is None or onward[0][2] in joints:
            return tuple(joints), tuple(pieces)
        ((element, _, joint),) = onward
        joints.append(joint)
        pieces.append(_piece(section, element, str(element.shape), material))


@dataclass(frozen=True)
class _Row:
    """One element of the chain, its nodes by name."""

    left: str
    right: str
    stiffness: float
    damping: float
    loss_factor: float
    distributed_inertia: float
    law: VaryingPart | None = None


def chain_of(section: ChainSection, material: Material) -> Chain:
    """Return the chain that a file describes.

    Parameters
    ----------
    material : Material
        Of its pieces of shaft.
    """
    base = getattr(section, "base", None)
    nodes = _nodes(section, base)
    names = tuple(nodes)
    errors = InputErrors()
    kind, make_node = KINDS[section.kind], cast(Any, KINDS[section.kind].node)
    modulus = kind.modulus
    if getattr(section, modulus) is not None and not any(part.shape for part in section.elements):
        raise InputError(
            f"chain.{modulus}: given without a piece of shaft; allowed is it where [[chain.elements]] have a "
            "shape, because a stiffness that is given needs no modulus."
        )
    inner: dict[str | None, list[str]] = {}
    rows: list[_Row] = []
    for number, element in _elements(section, names, base):
        with errors.noted():
            left, right = _ends(element, number, names)
            if element.shape is None:
                rows.append(_spring(section, number, element, left, right, base))
                continue
            _check_shape(number, element, element.shape)
            between = [f"{left} - {right} {k}" for k in range(1, element.parts)]
            pieces = _piece(section, element, element.shape, material).divided(element.parts)
            loss = in_si(element, f"chain.elements[{number}]", "loss_factor", base)
            joints = [left, *between, right]
            for piece, start, end in zip(pieces, joints[:-1], joints[1:], strict=True):
                torsional = section.kind == "torsional"
                compliance = piece.torsional_compliance if torsional else piece.axial_compliance
                spread = piece.polar_inertia if torsional else piece.mass
                rows.append(_Row(start, end, 1.0 / compliance, 0.0, loss, spread))
            # Between neighbors the inner nodes stand in their place of the row, otherwise at its end.
            places = names.index(left), names.index(right)
            host = names[min(places)] if abs(places[0] - places[1]) == 1 else None
            inner.setdefault(host, []).extend(between if host == left else between[::-1])
    order = [name for node in names for name in (node, *inner.get(node, ()))] + inner.get(None, [])
    number_of = {name: number for number, name in enumerate(order)}
    # Inner nodes of a piece of shaft have nothing but its own inertia.
    values = [nodes.get(name, make_node(name=name)) for name in order]

    def place(field: str, name: str) -> int:
        check_choice(f"chain.{field}", name, names, "these are the nodes")
        return number_of[name]

    dashpots: list[Dashpot] = []
    for k, dashpot in enumerate(section.dashpots):
        with errors.noted():
            first, second = (place(f"dashpots[{k}].nodes", name) for name in dashpot.nodes)
            dashpots.append(Dashpot(first, second, dashpot.damping))
    gears: list[Gear] = []
    for k, gear in enumerate(section.gears):
        with errors.noted():
            driver = place(f"gears[{k}].driver", gear.driver)
            gears.append(Gear(driver, place(f"gears[{k}].driven", gear.driven), gear.ratio))
    joined = {frozenset((gear.driver, gear.driven)) for gear in section.gears}
    rigid = zip(names, names[1:], in_si(section, "chain", "stiffness", base) or (), strict=False)
    gears += [
        Gear(number_of[left], number_of[right], 1.0)
        for left, right, stiffness in rigid
        if math.isinf(stiffness) and {left, right} not in joined
    ]
    for k, part in enumerate(section.dampers):
        with errors.noted():
            place(f"dampers[{k}].node", part.node)
    errors.tell()
    grounds = [
        varied(node.variation, node.ground_stiffness, damping=node.ground_damping)
        for node in values
    ]
    laws = [Varying(k, row.law) for k, row in enumerate(rows) if row.law is not None]
    laws += [Varying(k, law, True) for k, (*_, law) in enumerate(grounds) if law is not None]
    places_of = {name: f"chain.nodes[{k}]" for k, name in enumerate(names)}
    chain = Chain(
        [
            in_si(node, places_of.get(node.name, "chain"), kind.inertia, base)
            * (1.0 + node.entrained_share)
            for node in values
        ],
        [row.stiffness for row in rows],
        [ground[0] for ground in grounds],
        connections=[(number_of[row.left], number_of[row.right]) for row in rows],
        damping=[row.damping for row in rows],
        loss_factor=[row.loss_factor for row in rows],
        ground_damping=[ground[2] for ground in grounds],
        distributed_inertia=[row.distributed_inertia for row in rows],
        dashpots=dashpots,
        gears=gears,
        varying=laws,
        names=order,
    )
    if reference := getattr(section, "referred_to", None):
        chain = replace(chain, **at_own_speeds(chain, reference, section))
    for k, part in enumerate(section.dampers):
        chain = with_damper(chain, part.node, part.damper(f"chain.dampers[{k}]"))
    return chain


def _nodes(section: ChainSection, base: PerUnitBase | None) -> dict[str, Node]:
    kind = KINDS[section.kind]
    field = kind.inertia
    listed = in_si(section, "chain", field, base)
    if (listed is None) == (not section.nodes):
        raise InputError(
            f"chain.{field}: given {'neither it nor' if listed is None else 'both it and'} [[chain.nodes]]; "
            "allowed is one of the two, because both define the nodes."
        )
    if listed is None:
        for beside in ("names", *GROUND_FIELDS):
            if getattr(section, beside) is not None:
                raise InputError(
                    f"chain.{beside}: given together with [[chain.nodes]]; allowed is one of the two, "
                    "because each node has its own there."
                )
        nodes_by_name: dict[str, Node] = {}
        for number, node in enumerate(section.nodes):
            if node.name in nodes_by_name:
                raise InputError(
                    f"chain.nodes[{number}].name: given {node.name!r} a second time; allowed is a "
                    "different one for each node, because results are named by them."
                )
            nodes_by_name[node.name] = node
        return nodes_by_name
    names = section.names or tuple(f"node {number}" for number in range(len(listed)))
    if len(names) != len(listed) or len(set(names)) != len(names):
        raise InputError(
            f"chain.names: given {len(names)} names, {len(set(names))} of them different, for {len(listed)} "
            f"values of {field}; allowed is a different one for each, because results are named by them."
        )
    grounds = []
    for beside in GROUND_FIELDS:
        values: tuple[float, ...] | None = getattr(section, beside)
        if values is not None and len(values) != len(listed):
            raise InputError(
                f"chain.{beside}: given {so_many(len(values))} for {len(listed)} nodes; allowed is one for "
                "each, because each has its own."
            )
        grounds.append(values or (0.0,) * len(listed))
    make: Any = kind.node
    return {
        name: make(name=name, **{field: inertia}, ground_stiffness=spring, ground_damping=damping)
        for name, inertia, spring, damping in zip(names, listed, *grounds, strict=True)
    }


def _elements(
    section: ChainSection, names: tuple[str, ...], base: PerUnitBase | None
) -> Iterable[tuple[int, Element]]:
    listed = in_si(section, "chain", "stiffness", base)
    losses = in_si(section, "chain", "loss_factor", base)
    if listed is None:
        for field in ("damping", "loss_factor", *CONVENTIONS):
            if getattr(section, field):
                raise InputError(
                    f"chain.{field}: given without a list of stiffness; allowed is {field} of each of "
                    "[[chain.elements]], because it belongs to an element."
                )
        return enumerate(section.elements)
    if section.elements:
        raise InputError(
            "chain.stiffness: given both it and [[chain.elements]]; allowed is one of the two, because both "
            "define the elements."
        )
    count, nodes = len(listed), len(names)
    if count != nodes - 1:
        raise InputError(
            f"chain.stiffness: given {so_many(count)} for {nodes} nodes; allowed are exactly {nodes - 1}, "
            "because one spring joins each two neighbors."
        )
    damping = _of_each("chain.damping", section.damping, count)
    loss = _of_each("chain.loss_factor", losses, count)
    make = KINDS[section.kind].element
    return [
        (k, make(stiffness=stiffness, damping=c, loss_factor=h))
        for k, (stiffness, c, h) in enumerate(zip(listed, damping, loss, strict=True))
        if not math.isinf(stiffness)
    ]


def _of_each(field: str, values: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    listed = (values,) * count if isinstance(values, float) else values
    if len(listed) != count:
        raise InputError(
            f"{field}: given {so_many(len(listed))} for {count} elements; allowed is one for each, or a "
            "single one for all, because each element has its own."
        )
    return listed


def _ends(element: Element, number: int, nodes: tuple[str, ...]) -> tuple[str, str]:
    if element.nodes is None:
        if number + 1 >= len(nodes):
            raise InputError(
                f"chain.elements[{number}].nodes: missing; allowed are the names of two nodes, because "
                f"there is no node of number {number + 1} that it could lead to by default."
            )
        return nodes[number], nodes[number + 1]
    for name in element.nodes:
        check_choice(f"chain.elements[{number}].nodes", name, nodes, "these are the nodes")
    if element.nodes[0] == element.nodes[1]:
        raise InputError(
            f"chain.elements[{number}].nodes: given {element.nodes[0]!r} twice; allowed are two "
            "different nodes, because what joins a node to itself does nothing."
        )
    return element.nodes


def _spring(
    section: ChainSection,
    number: int,
    element: Element,
    left: str,
    right: str,
    base: PerUnitBase | None,
) -> _Row:
    field = f"chain.elements[{number}].stiffness"
    where = f"chain.elements[{number}]"
    given_stiffness = in_si(element, where, "stiffness", base)
    if given_stiffness is None:
        raise InputError(
            f"{field}: given neither it nor shape; allowed is one of the two, because both define the "
            "stiffness of the element."
        )
    for name in (*SHAPE_FIELDS, "parts", KINDS[section.kind].modulus):
        _link_error(number, element, name, "stiffness")
    stiffness = positive_number(
        field,
        given_stiffness,
        UNITS[section.kind]["stiffness"],
        "a spring without stiffness cuts the chain in two",
    )
    stiffness, loss_factor, damping, law = varied(
        element.variation, stiffness, in_si(element, where, "loss_factor", base), element.damping
    )
    return _Row(left, right, stiffness, damping, loss_factor, element.distributed_inertia, law)


def _check_shape(number: int, element: Element, shape: str) -> None:
    springs = (
        "stiffness",
        "flexibility",
        "per_unit_stiffness",
        "damping",
        "distributed_inertia",
        "variation",
    )
    for name in springs:
        if name in type(element).model_fields:
            _link_error(number, element, name, "shape")
    for name in SHAPE_FIELDS:
        if name not in SHAPES[shape]:
            _link_error(number, element, name, f"shape {shape}")
        elif getattr(element, name) is None:
            raise InputError(
                f"chain.elements[{number}].{name}: missing; allowed is a length above 0 mm, because a "
                f"{shape} has it."
            )


def _link_error(number: int, element: Element, name: str, beside: str) -> None:
    if getattr(element, name) != type(element).model_fields[name].default:
        raise InputError(
            f"chain.elements[{number}].{name}: given together with {beside}; allowed is one of the two, "
            "because the element is a spring or a piece of shaft of one shape."
        )


def _piece(section: ChainSection, element: Element, shape: str, steel: Material) -> ShaftCone:
    key = KINDS[section.kind].modulus
    modulus = getattr(element, key) or getattr(section, key) or getattr(steel, key)
    other = "youngs_modulus" if key == "shear_modulus" else "shear_modulus"
    both = {key: modulus, other: getattr(steel, other) * modulus / getattr(steel, key)}
    material = ShaftMaterial(**both, density=steel.density)
    sizes = {name: getattr(element, name) for name in SHAPES[shape]}
    if shape == "cone":
        return ShaftCone(**sizes, material=material)
    if shape == "flange":
        return shaft_flange(sizes["length"], sizes["diameter"], sizes["bore"], material)
    return shaft_cylinder(**sizes, material=material)
