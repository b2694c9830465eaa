"""Excitation of an engine's chains: forces of its cylinders over the speeds, torques, a propeller."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import (
    full_load_only,
    pressure_maps,
)
from crankfem.analyses.shaft.chains import (
    damped_engine_chain,
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.analyses.shaft.sources import (
    axial_by_formulas,
    refuse_law,
    torsional_by_formulas,
    usable_model,
)
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.analyses.vibration.engine_limits import (
    ANY_COMPLIANCE,
    ANY_INERTIA,
    assessment_end_speeds,
    bending_speeds,
    refuse_limits,
)
from crankfem.analyses.vibration.engine_load import pressure_over_speeds
from crankfem.analyses.vibration.modes import SourceResult
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.full_load import motored_for_misfire
from crankfem.files.sections.excitation_sections import (
    Misfire,
    gas_map_load,
)
from dynamics.chains.engine_chains import EngineChain, Kind
from dynamics.critical import engine_orders
from dynamics.excitation.chain_excitation import (
    AxialForceComparison,
    axial_excitation,
    axial_excitation_of_torsion,
    combined_excitation,
    compare_axial_forces,
    torsion_influence,
)
from dynamics.excitation.cylinders import (
    CylinderForces,
    CylinderHarmonics,
    cylinder_harmonics,
    forces_at_speeds,
)
from dynamics.excitation.pressure_map import (
    constant_weight,
)
from dynamics.excitation.propeller import propeller_excitation
from dynamics.indices import within
from dynamics.response.forced import ForcedResponse
from dynamics.response.linear_system import DEFAULT_MAGNIFIER, DampedChain
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.resonance import refined_speeds

if TYPE_CHECKING:
    from fem.superelement import ShaftCompliances

# Speeds below the lowest running one are passed on every start; rules of limits go on above the highest
# running speed and the rated one.
BELOW, ABOVE_HIGHEST, ABOVE_RATED = 0.5, 1.05, 1.15
# Of the even grid; resonances get further speeds.
POINTS = 150
# Speeds within this share of each other are one.
SAME_SPEED = 1e-9

Frequencies = Sequence[float] | Array


def engine_harmonics(
    engine_file: EngineFile, above_rated: float = ABOVE_RATED
) -> CylinderHarmonics:
    """Harmonics of the pin forces of an engine's cylinders, up to the file's highest order.

    Parameters
    ----------
    engine_file : EngineFile
        With gas pressure. Its load, or its pressure map, determines that at each speed; full load by
        default.
    above_rated : float, optional
        As of `calculated_range`.

    Raises
    ------
    InputError
        If a pressure cannot be read, or its samples do not resolve the highest order.
    """
    speed_range = calculated_range(engine_file, above_rated)
    pressure = pressure_over_speeds(engine_file, speed_range)
    return cylinder_harmonics(
        engine_file.layout,
        engine_orders(engine_file.engine.strokes, engine_file.vibration.highest_order),
        pressure,
        throws=engine_file.throws,
    )


def failing_harmonics(
    engine_file: EngineFile,
    firing: CylinderHarmonics,
    above_rated: float = ABOVE_RATED,
    *,
    misfire: Misfire | None = None,
) -> CylinderHarmonics:
    """Harmonics of the pin forces of cylinders without combustion.

    Parameters
    ----------
    engine_file : EngineFile
        Its section [misfire] may exclude compression, too; then no gas acts.
    misfire : Misfire, optional
        In place of that section.

    Raises
    ------
    InputError
        If the pressure without combustion is unknown: there is no section [gas], or its table shows
        no compression.
    """
    misfire = misfire or engine_file.misfire
    if misfire is not None and not misfire.compression:
        none = tuple(np.zeros((1, *gas.shape[1:]), dtype=np.complex128) for gas in firing.gas)
        weights = (constant_weight,) * len(none)
        return replace(firing, gas=none, weights=weights, takes_load=False)
    if engine_file.gas is None:
        raise InputError(
            "misfire: given without the section [gas]; allowed are both, or compression = false, because "
            "the pressure without combustion follows from it."
        )
    motored = (
        motored_for_misfire(engine_file.gas, engine_file.layout, engine_file.pressure)
        if full_load_only(engine_file)
        else pressure_maps(engine_file, calculated_range(engine_file, above_rated), motored=True)
    )
    return cylinder_harmonics(engine_file.layout, firing.orders, motored, throws=engine_file.throws)


def calculated_speeds(
    engine_file: EngineFile,
    orders: Array,
    chains: Sequence[DampedChain],
    further: Frequencies = (),
    above_rated: float = ABOVE_RATED,
) -> Array:
    """Return speeds that include every resonance, kinks of limits and ends of assessed ranges.

    Parameters
    ----------
    orders : (K,) array
    further : (m,) array, optional
        Further natural frequencies [Hz].

    Returns
    -------
    (S,) array
        From half the lowest running speed to 5 % above the highest (and 15 % above the rated one), within
        the pressure map or the load's points, if any [rad/s].
    """
    ratios = [np.maximum(chain.system.damping_ratios(), 1e-4) for chain in chains]
    low, high = calculated_range(engine_file, above_rated)
    speeds = refined_speeds(
        np.concatenate([*(chain.system.elastic_frequencies for chain in chains), further]),
        np.concatenate([*ratios, np.full(len(further), 0.5 / DEFAULT_MAGNIFIER)]),
        orders,
        (low, high),
        points=POINTS,
    )
    for system in (chain.system for chain in chains if chain.system.varying):
        for order in orders.tolist():
            frequencies, damping = system.frequencies_met(order)
            damping = np.maximum(damping, 1e-4)
            about = refined_speeds(frequencies, damping, [order], (low, high), points=POINTS)
            speeds = np.union1d(speeds, about)
    ends = (*assessment_end_speeds(engine_file), *bending_speeds(engine_file))
    return merged_speeds(speeds, [min(end, high) for end in ends if within(end, low, high)])


def merged_speeds(speeds: Frequencies, others: Frequencies) -> Array:
    """Return speeds with others added, ascending; nearly equal ones are dropped."""
    known = np.asarray(speeds, dtype=np.float64)
    added = np.unique(np.asarray(others, dtype=np.float64))
    added = added[np.diff(added, prepend=0.0) > SAME_SPEED * added]
    near = np.min(np.abs(known[:, np.newaxis] - added), axis=1, initial=np.inf)
    return np.sort(np.concatenate((known[near > SAME_SPEED * known], added)))


def forces_over_speeds(
    engine_file: EngineFile, harmonics: CylinderHarmonics, speeds: Array
) -> CylinderForces:
    """Return the forces of the cylinders at speeds [rad/s].

    Parameters
    ----------
    speeds : (S,) array
        Ascending, as those of `calculated_speeds`.
    """
    load = None
    if engine_file.gas_map is not None:
        load = gas_map_load(engine_file.gas_map, engine_file.engine.rated_speed)
    return forces_at_speeds(harmonics, speeds, load)


def excitation_along_shaft(
    engine_file: EngineFile,
    forces: CylinderForces,
    axial: SourceResult,
    shaft: "ShaftCompliances",
    cranks: EngineChain,
    twisted: ForcedResponse,
) -> tuple[OrderExcitation, OrderExcitation | None, tuple[str, ...]]:
    """Return the axial force of each throw due to radial forces and to torques in the shaft.

    For any source of the chain's compliances, the exciting forces are those of the finite
    elements: lengthening over compliance, both of the assembled shaft.

    Parameters
    ----------
    axial : SourceResult
        The axial chain and its compliances.

    Returns
    -------
    by_torque : OrderExcitation or None
        The part due to torques in the shaft.
    remarks : tuple of str
        Parts left out.
    """
    scale = (axial.compliances / shaft.axial)[:, None]
    by_radial = axial_excitation(
        forces, axial.chain, axial.compliances, scale * shaft.influence, engine_file.pins
    )
    if shaft.tangential.shape[1] != len(shaft.axial):
        several = (
            "the axial force that torque in the shaft excites is left out, because throws have several "
            "pins"
        )
        return by_radial, None, (several,)
    if np.any(twisted.unbounded):
        endless = (
            "the axial force that torque in the shaft excites is left out, because torsional vibration "
            "is unbounded"
        )
        return by_radial, None, (endless,)
    # The finite elements count angles as the file does, torques here are positive as the shaft turns.
    sense = engine_file.engine.turning_sense
    influence = torsion_influence(
        sense * shaft.tangential, sense * shaft.through, engine_file.throw.crank_radius
    )
    by_torque = axial_excitation_of_torsion(
        twisted, cranks, axial.chain, axial.compliances, scale * influence
    )
    return combined_excitation(by_radial, by_torque), by_torque, ()


def excitation_remarks(engine_file: EngineFile, kind: Kind) -> tuple[str, ...]:
    """Remarks on excitation other than cylinders that all fire with one diagram."""
    remarks = []
    if engine_file.gas_map is not None:
        count = len(engine_file.gas_map.points)
        beside = "" if engine_file.gas is None else ", in place of the section [gas]"
        remarks.append(f"the cylinders' pressure follows a map of {count} diagrams{beside}")
    propeller_forces = engine_file.propeller_forces
    if propeller_forces is not None and (
        propeller_forces.torque_shares if kind == "torsional" else propeller_forces.thrust_shares
    ):
        remarks.append(
            f"the propeller's {'torque' if kind == 'torsional' else 'thrust'} varies at node "
            f"{propeller_forces.node}"
        )
    return tuple(remarks)


def with_propeller(
    engine_file: EngineFile, chain: EngineChain, excitation: OrderExcitation
) -> OrderExcitation:
    """Add the excitation by a propeller, if the file gives its harmonics for this kind.

    Raises
    ------
    InputError
        If the chain has no such node.
    """
    propeller_forces = engine_file.propeller_forces
    if propeller_forces is None:
        return excitation
    if not (
        propeller_forces.torque_shares
        if chain.kind == "torsional"
        else propeller_forces.thrust_shares
    ):
        return excitation
    if propeller_forces.node not in chain.nodes:
        raise InputError(
            f"propeller_forces.node: given {propeller_forces.node!r}; allowed are "
            f"{', '.join(chain.nodes)}, because these are the nodes of the {chain.kind} "
            "chain (a shaft line brings the propeller's)."
        )
    acting = propeller_excitation(
        propeller_forces.forces,
        chain.chain,
        chain.nodes.index(propeller_forces.node),
        excitation.speeds,
        kind=chain.kind,
        ratio=propeller_forces.ratio,
    )
    return combined_excitation(excitation, acting)


def compared_axial_forces(
    engine_file: EngineFile,
    forces: CylinderForces,
    compliances: Array,
    shaft: "ShaftCompliances",
    analysis: Analyses,
) -> AxialForceComparison:
    """Return the force c Z / e_n of each single throw, and that in the assembled shaft.

    Parameters
    ----------
    compliances : (n,) array
        Of the axial chain [m/N].
    analysis : ThrowAnalysis or mapping
        Of the engine's throw, or of each throw by its name.
    """
    each = crank_analyses(engine_file, analysis)
    return compare_axial_forces(
        forces,
        compliances,
        [throw.influence_coefficient("pinned") for throw in each],
        shaft.influence * (compliances / shaft.axial)[:, None],
        own_compliances=[throw.axial_compliance("pinned") for throw in each],
        pins=engine_file.pins,
    )


def calculated_range(
    engine_file: EngineFile, above_rated: float = ABOVE_RATED
) -> tuple[float, float]:
    """From half the lowest running speed to above the highest one, within the pressure map.

    Parameters
    ----------
    above_rated : float, optional
        Share of the rated speed that is included unless a map or points end before.
    """
    engine = engine_file.engine
    low = BELOW * engine.lowest_speed
    high = max(ABOVE_HIGHEST * engine.highest_speed, above_rated * engine.rated_speed)
    load = engine_file.gas_map or engine_file.load
    if load is not None and load.points:
        taken = [point.speed for point in load.points]
        low = min(max(low, min(taken)), engine.lowest_speed)
        high = max(min(high, max(taken)), engine.highest_speed)
    return low, high


def refuse_vibration(engine_file: EngineFile) -> None:
    """Refuse limits, sources of compliances and parts of chains with which no vibration is calculated."""
    refuse_limits(engine_file)
    refuse_law(engine_file)
    # A published formula may give a throw no compliance above zero.
    throws, material = engine_file.crank_throws, engine_file.material
    vibration = engine_file.vibration
    for kind, source, sources in (
        (
            "axial",
            vibration.axial_source,
            axial_by_formulas(throws, engine_file.throw_angles_deg, material),
        ),
        ("torsional", vibration.torsional_source, torsional_by_formulas(throws, material)),
    ):
        for name, (values, _) in sources.items():
            if name.casefold() == source.casefold() and not np.all(values > 0.0):
                raise InputError(
                    f"vibration.{kind}_source: given {source!r}, which gives a throw a compliance of "
                    f"{np.min(values):.3g}; give another source, such as 'fe', because a compliance is above "
                    "zero."
                )
    # What does not fit the chains is refused whatever their throws' compliances are.
    count = len(engine_file.throw_angles_deg)
    compliances, some = np.full(count, ANY_COMPLIANCE), np.full(count, ANY_INERTIA)
    inertias = engine_throw_inertias(engine_file, ANY_INERTIA)
    for chain in (
        engine_axial_chain(engine_file, compliances, some),
        engine_torsional_chain(engine_file, compliances, inertias),
    ):
        _ = damped_engine_chain(engine_file, chain)
        still = np.zeros((1, 1, len(chain.nodes)), dtype=np.complex128)
        speed = np.array([engine_file.engine.rated_speed])
        excitation = OrderExcitation(np.ones(1), speed, still)
        _ = with_propeller(engine_file, chain, excitation)


def refuse_forced_vibration(engine_file: EngineFile) -> None:
    """Refuse pressures that cannot be reached or resolved, and a saved model that does not fit, too."""
    refuse_vibration(engine_file)
    if engine_file.gas is not None or engine_file.gas_map is not None:
        harmonics = engine_harmonics(engine_file)
        if engine_file.misfire is not None:
            _ = failing_harmonics(engine_file, harmonics)
    if engine_file.vibration.model is not None:
        usable_model(engine_file, None)
