"""Values of chains as makers print them: flexibility, GD2, per unit, relative damping, at one speed."""

import math
import re
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.model import GD2, InputModel, quantity_field
from dynamics.chains.chain import Chain
from dynamics.chains.coupling_damping import CONVENTIONS, SMALLEST_MAGNIFIER, in_all_conventions


class PerUnitBase(InputModel):
    """What values per unit are multiples of."""

    section: ClassVar[str] = "chain.base"

    power: float = quantity_field("rated apparent power", "VA", 1.0, 1e12)
    speed: float = quantity_field("rated speed", "rad/s", 0.1, 1e5)
    frequency: float = quantity_field("electrical frequency", "Hz", 1.0, 1e4)

    @property
    def inertia(self) -> float:
        """Moment of inertia of H = 1 s [kg m^2]: it stores the power for a second."""
        return 2.0 * self.power / self.speed**2

    @property
    def stiffness(self) -> float:
        """Stiffness of one rated torque per electrical radian [N m/rad]."""
        return self.power / self.speed * 2.0 * math.pi * self.frequency / self.speed


class Form(NamedTuple):
    """Another way to give a value: the field it stands for, its size in SI, and whether it needs a base."""

    stands_for: str
    in_si: Callable[[float, Any], float]
    per_unit: bool = False


def _converted(convert: Callable[[float], float], size: float, _base: object) -> float:
    return convert(size)


FORMS = {
    "inertia_constant": Form("inertia", lambda h, base: h * base.inertia, True),
    # A flexibility of zero is a rigid joint.
    "flexibility": Form("stiffness", lambda e, _: 1.0 / e if e else math.inf),
    "per_unit_stiffness": Form("stiffness", lambda k, base: k * base.stiffness, True),
    **{
        name: Form("loss_factor", partial(_converted, convert))
        for name, convert in CONVENTIONS.items()
    },
}


def in_si(part: InputModel, where: str, field: str, base: PerUnitBase | None) -> Any:
    """Return a field of a node, an element or the lists of a chain [SI], in whatever form it is given.

    Parameters
    ----------
    where : str
        What messages call the part, such as ``chain.nodes[0]``.
    field : {"inertia", "mass", "stiffness", "loss_factor"}
    """
    values, taken_from = getattr(part, field), field
    for name, form in FORMS.items():
        other = getattr(part, name, None)
        if form.stands_for != field or other is None:
            continue
        if values:
            raise InputError(
                f"{where}.{name}: given together with {taken_from}; allowed is one of the two, because both "
                f"are the {field} in another form."
            )
        if form.per_unit and base is None:
            raise InputError(
                f"{where}.{name}: given without [chain.base]; allowed is it with power, speed and "
                "frequency, because the value is per unit of them."
            )
        many = isinstance(other, tuple)
        listed = other if many else (other,)
        lowest = SMALLEST_MAGNIFIER if name == "magnifier" else 0.0
        if min(listed, default=lowest) < lowest:
            raise InputError(
                f"{where}.{name}: given {min(listed):g}; allowed are numbers from {lowest:g}, because "
                "others are no size of a machine."
            )
        values = tuple(form.in_si(size, base) for size in listed)
        values = values if many else values[0]
        taken_from = name
    return values


def at_own_speeds(chain: Chain, reference: str, section: Any) -> dict[str, Any]:
    """Return the values of a chain at each node's own speed, of values at the speed of one node.

    Energy is the same at both: what turns r times as fast has 1/r^2 of the referred value.
    """
    check_choice("chain.referred_to", reference, chain.names, "these are the nodes")
    own_speeds_only = section.dashpots or any(e.shape or e.variation for e in section.elements)
    if own_speeds_only or any(node.variation for node in section.nodes):
        raise InputError(
            f"chain.referred_to: given {reference!r} with a shape, a variation or [[chain.dashpots]]; "
            "allowed is it without, because these are known at their own speeds."
        )
    ratios = chain.speed_ratios
    nodes = (ratios / ratios[chain.names.index(reference)]) ** -2.0
    elements = nodes[[left for left, _ in chain.connections]]
    sizes = {name: getattr(chain, name) * nodes for name in ("inertia", "ground", "ground_damping")}
    return sizes | {
        name: getattr(chain, name) * elements
        for name in ("stiffness", "damping", "distributed_inertia")
    }


def as_printed(chain: Chain, values: dict[str, Any], units: dict[str, str]) -> tuple[str, ...]:
    """Return the table of a maker as it was given, each value beside what it is in SI at its own speed.

    Parameters
    ----------
    values : dict
        The section [chain] of the file.
    units : dict
        SI units of inertia and stiffness.
    """
    parts = [*values.get("nodes", ()), *values.get("elements", ())]
    pounds = re.search(r"\d lbs?\b", str(values))
    other = {GD2, *FORMS}
    if not pounds and not any({*other, "referred_to"} & part.keys() for part in (values, *parts)):
        return ()
    kept = ("inertia", "mass", "stiffness", "loss_factor", GD2, *FORMS)
    rows: list[tuple[str, Any, int]] = [
        (chain.names[k], values, k) for k in range(len(chain.names))
    ]
    if values.get("nodes"):
        rows = [(node["name"], node, 0) for node in values["nodes"]]
    rows += [
        (" - ".join(element.get("nodes", (f"element {k}",))), element, 0)
        for k, element in enumerate(values.get("elements", ()))
    ]
    lines = []
    for name, part, place in rows:
        columns = []
        for field in kept:
            if (printed := part.get(field)) is None:
                continue
            listed = isinstance(printed, list)
            if not listed or place < len(printed):
                columns.append(f"{field} {printed[place] if listed else printed}")
        if columns:
            lines.append(f"as printed: {name}: {', '.join(columns)}")
    inertia, stiffness = (units[field] for field in ("inertia", "stiffness"))
    lines += [
        f"in SI at its own speed: {name}: inertia {size:.6g} {inertia}"
        for name, size in zip(chain.names, chain.inertia, strict=True)
    ]
    springs = zip(chain.elements, chain.stiffness, chain.loss_factor, strict=True)
    lines += [
        f"in SI at its own speed: {name}: stiffness {size:.6g} {stiffness}"
        + (f", {in_all_conventions(loss)}" if loss else "")
        for name, size, loss in springs
    ]
    return tuple(lines)
