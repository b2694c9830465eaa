"""Node or element of a run shown in a diagram, and its unit."""

from typing import Any, Literal, NamedTuple, TypeAlias

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.library_types import Dataset
from crankbase.tables.frames import grid
from dynamics.chains.chain import Chain
from dynamics.indices import index_of_name
from dynamics.plots.coordinates import Coordinate, name_axis
from dynamics.plots.quantities import MOVING, SI_UNITS

Moving: TypeAlias = Literal["torque", "force", "twist", "displacement"]
OF_ELEMENTS = ("torque", "force")


class SelectedCurve(NamedTuple):
    """The curve of a diagram.

    Parameters
    ----------
    values : ndarray of shape (m,)
        In the unit of the axis.
    number : int
        Of the element or node.
    name : str
        Of the element or node.
    label : str
        Of the axis, with its unit.
    factor : float
        Factor from SI to the unit of the axis.
    of_element : bool
        Whether it is the load of an element, not the motion of a node.
    """

    values: FloatArray
    number: int
    name: str
    label: str
    factor: float
    of_element: bool


def select_curve(
    chain: Chain | None, quantity: Moving, place: int | str, motion: FloatArray, torque: FloatArray
) -> SelectedCurve:
    """Select the motion of a node or the load of an element.

    Parameters
    ----------
    chain : Chain or None
    quantity : {"torque", "force", "twist", "displacement"}
        Torque or force of an element, or twist or displacement of a node.
    place : int or str
        Number from 0, or name.
    motion : ndarray of shape (m, n)
    torque : ndarray of shape (m, e)

    Raises
    ------
    InputError
        If there is no chain, no such quantity, or no such element or node.
    """
    if chain is None or not isinstance(quantity, str) or quantity not in MOVING:
        raise InputError(
            f"quantity: given {quantity!r}; allowed are {', '.join(MOVING)} of a run of a chain, because "
            "its elements and nodes have names."
        )
    of_element = quantity in OF_ELEMENTS
    names, values = (chain.elements, torque) if of_element else (chain.names, motion)
    what = "the chain's elements" if of_element else "the chain's nodes"
    index = index_of_name("place", place, names, what, "a diagram shows one of them")
    label, factor = MOVING[quantity]
    return SelectedCurve(factor * values[:, index], index, names[index], label, factor, of_element)


def axis_names(chain: Chain | None, nodes: int, elements: int) -> tuple[list[str], list[str]]:
    """Return the names of nodes and elements for a table, numbers from 0 if there is no chain."""
    if chain is None:
        return [str(number) for number in range(nodes)], [str(own) for own in range(elements)]
    return list(chain.names), list(chain.elements)


def units_of(quantity: Moving | None) -> tuple[str, str]:
    """Return the units in SI of the motion of nodes and of the loads of elements.

    Parameters
    ----------
    quantity : {"torque", "force", "twist", "displacement"} or None
        That of a torsional or of an axial chain; None for a chain of unknown kind.

    Raises
    ------
    InputError
        If it is none of these.

    Examples
    --------
    >>> units_of("twist"), units_of("displacement"), units_of(None)
    (('rad', 'N m'), ('m', 'N'), ('rad or m', 'N m or N'))
    """
    if quantity is None:
        return "rad or m", "N m or N"
    check_choice("quantity", quantity, MOVING, "a chain is torsional or axial")
    if quantity in ("torque", "twist"):
        return SI_UNITS["twist"], SI_UNITS["torque"]
    return SI_UNITS["displacement"], SI_UNITS["force"]


def motion_grid(
    chain: Chain | None,
    over: dict[str, Coordinate],
    motion: FloatArray,
    torque: FloatArray,
    quantity: Moving | None,
    words: str = "motion",
    **more: Any,
) -> Dataset:
    """Return motions (m, n) and torques (m, e) as arrays over node or element and one axis more.

    Parameters
    ----------
    chain : Chain or None
    over : dict
        Name and coordinate of the axis of the rows.
    motion, torque : ndarray
    quantity : str or None
        As for `units_of`.
    words : str, optional
        Quantity of the motion.
    **more
        Other arrays of the dataset, for `grid`.

    Raises
    ------
    InputError
        If there is no such quantity.
    """
    (axis,) = over
    moved, loaded = units_of(quantity)
    nodes, elements = axis_names(chain, motion.shape[1], torque.shape[1])
    return grid(
        {
            **more,
            "motion": ((axis, "node"), motion, moved, words),
            "torque": ((axis, "element"), torque, loaded, "load of the spring"),
        },
        {**over, "node": name_axis(nodes, "node"), "element": name_axis(elements, "element")},
    )
