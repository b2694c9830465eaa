"""Vibratory torque or force in each element, and the nominal stress from it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import ComplexArray, FloatArray, finite_array, positive_vector
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.library_types import Axes
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.indices import index_of_name
from dynamics.plots.quantities import Quantity, quantity_display
from dynamics.response.forced import ForcedResponse
from dynamics.response.series import DrawnBeside, OrderSeries


@summarized("elastic.orders", "elastic.speeds [rad/s]", "elastic.names")
@dataclass(frozen=True, eq=False)
class ElementLoads:
    """Loads [N m or N] by order and speed; each is a series that can be summed over the cycle.

    Parameters
    ----------
    elements : OrderSeries
        Total load of each element: (k (1 + i eta) + i w c) times its twist or
        lengthening d, the motion of its second node minus that of its first. Positive where it
        drives the first node forwards and holds the second one back.
    elastic : OrderSeries
        The part k d, which strains the element; the rest is loss factor and viscous damping.
    ground : OrderSeries
        Load of each node's spring and damper to ground, (g + i w c) x; zero at a
        node without.
    dashpots : OrderSeries
        Load of each dashpot, i w c times its relative motion.

    Notes
    -----
    Along an element with distributed inertia the load varies; k d is its mean.
    """

    elements: OrderSeries
    elastic: OrderSeries
    ground: OrderSeries
    dashpots: OrderSeries

    def plot(
        self,
        axes: Axes | None = None,
        element: int | str = 0,
        *,
        quantity: Quantity | None = None,
        part: Literal["elastic", "elements", "ground", "dashpots"] = "elastic",
        **drawn: Unpack[DrawnBeside],
    ) -> Axes:
        """Draw one element's main orders, their synthesis and their plain sum over the speed.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        element : int or str, optional
            By number from 0 or name; of nodes or dashpots for these parts.
        quantity : {"twist", "displacement", "torque", "force", "stress"}, optional
            Quantity of the values, for the unit of the axis; SI by default.
        part : {"elastic", "elements", "ground", "dashpots"}, optional
            Which of the four series.
        **drawn
            As `DrawnBeside` says: limits, barred, main_orders.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If element, quantity or part is unknown, or a limit, range or number is invalid.
        """
        check_choice("part", part, PARTS, "one series is drawn")
        shown = quantity_display(quantity, "N m or N", "alternating load")
        series: OrderSeries = getattr(self, part)
        return series.draw(axes, element, shown, "element", **drawn)


PARTS = ("elastic", "elements", "ground", "dashpots")


def element_loads(response: ForcedResponse) -> ElementLoads:
    """Find the loads of all elements, connections to ground and dashpots of a chain.

    Raises
    ------
    InputError
        If the response is not that of a chain.
    """
    chain = chain_of(response)
    w = response.angular_frequencies[:, :, np.newaxis]
    twist = response.motion @ chain.elongations().T
    relative = response.motion @ chain.dashpot_elongations().T
    sizes = np.array([dashpot.damping for dashpot in chain.dashpots])

    def series(values: ComplexArray, names: tuple[str, ...]) -> OrderSeries:
        return OrderSeries(response.orders, response.speeds, values, response.unbounded, names)

    complex_stiffness = chain.stiffness * (1.0 + 1j * chain.loss_factor) + 1j * w * chain.damping
    return ElementLoads(
        elements=series(complex_stiffness * twist, chain.elements),
        elastic=series(chain.stiffness * twist, chain.elements),
        ground=series(
            (chain.ground + 1j * w * chain.ground_damping) * response.motion, chain.names
        ),
        dashpots=series(1j * w * sizes * relative, dashpot_names(chain)),
    )


def elastic_loads(response: ForcedResponse) -> ComplexArray:
    """Return the strain-related part of each element's load, (K, S, e): `ElementLoads.elastic` alone.

    Raises
    ------
    InputError
        If the response is not that of a chain.
    """
    chain = chain_of(response)
    return np.asarray(response.motion @ (chain.elongations().T * chain.stiffness))


def section_modulus(
    kind: Literal["torsional", "axial"], diameter: ArrayLike, bore: ArrayLike = 0.0
) -> FloatArray:
    """Return the divisor of a load for the nominal stress of round sections.

    Parameters
    ----------
    kind : {"torsional", "axial"}
        pi (D^4 - d^4) / (16 D) [m^3] for the shear stress at the surface under a torque, or the
        area pi (D^2 - d^2) / 4 [m^2] for the normal stress under a force.
    diameter, bore : float or array_like
        D and d [m].

    Raises
    ------
    InputError
        If a diameter is not above zero, a bore not from zero to below it, or the kind is unknown.
    """
    check_choice("kind", kind, ("torsional", "axial"), "a shaft is strained by torque or force")
    outer, inner = finite_array("diameter", diameter), finite_array("bore", bore)
    if np.any(outer <= 0.0):
        raise InputError(
            f"diameter: given {np.min(outer):g} m; allowed is more than zero, because a shaft has a section."
        )
    if np.any((inner < 0.0) | (inner >= outer)):
        raise InputError(
            f"bore: given {np.max(inner):g} m; allowed is from zero to below the diameter, because "
            "a shaft has a wall."
        )
    if kind == "axial":
        return np.asarray(np.pi / 4.0 * (outer**2 - inner**2))
    return np.asarray(np.pi / 16.0 * (outer**4 - inner**4) / outer)


def alternating_stress(
    loads: ElementLoads, sections: ArrayLike | Mapping[int, float] | Mapping[str, float]
) -> OrderSeries:
    """Return the nominal alternating stress [Pa] of elements, from the elastic part of their loads.

    Parameters
    ----------
    loads : ElementLoads
    sections : array_like of shape (e,) or mapping of element to float
        Section modulus in torsion [m^3] of a torsional chain, or area [m^2] of an axial one, of
        every element; or of some by number from 0 or by name, where others have no shaft section.
        `section_modulus` gives it from diameters.

    Returns
    -------
    OrderSeries
        Of the elements given, in the order of the chain. Nominal: without
        stress concentration factors.

    Raises
    ------
    InputError
        If an element does not exist, a section is not above zero, or lengths do not fit.
    """
    names = loads.elastic.names
    if isinstance(sections, Mapping):
        why = "a stress is that of an element"
        by_place = {
            index_of_name("sections", key, names, "elements", why): float(value)
            for key, value in sections.items()
        }
        places = sorted(by_place)
        sizes = [by_place[place] for place in places]
    else:
        places, sizes = list(range(len(names))), np.asarray(sections).tolist()
    moduli = positive_vector(
        "sections", sizes, "m^3 (torsional) or m^2 (axial)", "stress is load over section"
    )
    if moduli.size != len(places):
        raise InputError(
            f"sections: given {moduli.size} values for {len(places)} elements; allowed is one for "
            "each, or some by their numbers or names, because each element has its own."
        )
    return OrderSeries(
        orders=loads.elastic.orders,
        speeds=loads.elastic.speeds,
        values=loads.elastic.values[:, :, places] / moduli,
        unbounded=loads.elastic.unbounded,
        names=tuple(names[place] for place in places),
    )


def chain_of(response: ForcedResponse) -> Chain:
    """Return the chain of a response.

    Raises
    ------
    InputError
        If it is that of another system.
    """
    if response.chain is None:
        raise InputError(
            "response: given that of a system of matrices; allowed is that of a chain, because matrices "
            "have no elements."
        )
    return response.chain


def dashpot_names(chain: Chain) -> tuple[str, ...]:
    """Return the names of the dashpots by those of their nodes, (d,)."""
    return tuple(
        f"{chain.names[dashpot.left]} - {chain.names[dashpot.right]}" for dashpot in chain.dashpots
    )
