"""The whole crankshaft of an engine file, from superelements of its throws.

Throws are at their crank angles, equal ones with the same superelement; cylinders of a V engine act on the
pins that the file names.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import check_choice, check_kind, check_not_given
from crankbase.errors import InputError
from crankbase.frames import Axes, table_of
from crankbase.quantity import UNBOUNDED, percent
from crankbase.results import Hertz, Internal, Number, Part, Quantity, Result, Speed, result
from crankbase.sentences import amount, finished
from crankfem.analyses.shaft.chains import MOTION, magnifier_of, shaft_surroundings
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.files.chain.chain_file import PLANT
from crankfem.files.engine.engine_file import EngineFile
from dynamics import wording
from dynamics.chains.engine_chains import EngineChain, Kind
from dynamics.crankshaft.assembly import MOTION_OF, assemble_crankshaft
from dynamics.crankshaft.chain_comparison import (
    FREQUENCY_LIMIT,
    RESPONSE_LIMIT,
    ChainVerdict,
    FlywheelTilts,
    FrequencyDifference,
    frequency_difference,
    matching_modes,
    matching_response,
)
from dynamics.crankshaft.coupled_response import CoupledResponse, coupled_response
from dynamics.crankshaft.shaft_modes import (
    CrankshaftSystem,
    ShaftMode,
    ShaftModes,
    crankshaft_system,
    rotation_ratio,
)
from dynamics.crankshaft.surroundings import MainBearings, ShaftThrow
from dynamics.excitation.chain_excitation import combined_excitation
from dynamics.excitation.cylinders import CylinderForces
from dynamics.excitation.propeller import propeller_excitation
from dynamics.indices import within
from dynamics.response.forced import ForcedResponse
from dynamics.response.linear_system import DEFAULT_MAGNIFIER
from dynamics.response.loads import checked_power_balance
from dynamics.response.order_excitation import OrderExcitation
from fem.modes import DynamicSuperelement
from geometry.any_throw import Throw

# Share of critical damping that belongs to the assumed magnifier.
ASSUMED_RATIO = 0.5 / DEFAULT_MAGNIFIER


def modal_damping(engine_file: EngineFile, crankshaft: CrankshaftSystem) -> Array:
    """Return the damping of engine and shaft by modes: that of the chains, by the kind of motion.

    Returns
    -------
    ndarray of shape (kept + corrections,)
        Share of critical damping of each elastic mode that is kept, and of each correction.

    Notes
    -----
    Axial, torsional and bending motion each contribute their damping, by their share in the mode's
    energy: axial and torsional motion that of their chains, half of 1 / magnifier or of the loss factor;
    bending, and corrections, that of the bending magnifier, assumed by default. As in the chains, an
    assumed magnifier leaves out the share of strain in couplings, dampers and shaft lines with damping of
    their own, and the loss factor that of all of these.
    """
    modes, shaft = crankshaft.modes, crankshaft.shaft
    kept = slice(modes.rigid, modes.rigid + crankshaft.kept)
    shares, ratios = modes.shares[:, kept], _damping_ratios(engine_file)
    strain = (shaft.added_springs @ modes.shapes[:, kept] / modes.angular_frequencies[kept]) ** 2
    by_share = np.array(ratios) @ shares
    loss = 0.0 if engine_file.damping is None else engine_file.damping.loss_factor or 0.0
    kinds: tuple[Kind, ...] = ("axial", "torsional")
    for place, kind in enumerate(kinds):
        of_kind = shaft.spring_kinds == place
        if magnifier_of(engine_file, kind)[2]:
            left = strain[of_kind & shaft.damped_springs].sum(axis=0)
            by_share -= ratios[place] * np.minimum(left, shares[place])
        elif kind == "torsional":
            by_share -= 0.5 * loss * np.minimum(strain[of_kind].sum(axis=0), shares[place])
    return np.concatenate((by_share, np.full(crankshaft.corrections, ratios[-1])))


def damping_remarks(engine_file: EngineFile) -> tuple[str, ...]:
    """Return the damping of the whole crankshaft in addition to bearings and dampers, in words."""
    damping = engine_file.damping
    known = (False,) * 3
    if damping is not None:
        twisted = damping.torsional_magnifier is not None or damping.loss_factor
        known = (
            damping.axial_magnifier is not None,
            bool(twisted),
            damping.bending_magnifier is not None,
        )
    axial, torsional, bending = (
        f"{percent(ratio, 3)} %{'' if stated else ' (assumed)'}"
        for ratio, stated in zip(_damping_ratios(engine_file), known, strict=True)
    )
    remarks = [
        "modes have the damping of the chains, weighted by their energy shares, of critical damping: "
        f"axial motion {axial}, torsion {torsional}, bending {bending}"
    ]
    if engine_file.damping is not None and engine_file.damping.cylinder_damping:
        remarks.append(
            "the damping of the cylinders in torsion (damping.cylinder_damping), which the torsional chain "
            "has, is left out"
        )
    return tuple(remarks)


def _damping_ratios(engine_file: EngineFile) -> tuple[float, float, float]:
    """Shares of critical damping of axial, torsional and bending motion."""
    damping = engine_file.damping
    if damping is None:
        return (ASSUMED_RATIO,) * 3
    axial = 0.5 / (damping.axial_magnifier or DEFAULT_MAGNIFIER)
    if damping.torsional_magnifier is not None:
        torsional = 0.5 / damping.torsional_magnifier
    else:
        torsional = 0.0 if damping.loss_factor else ASSUMED_RATIO
    bending = 0.5 / (damping.bending_magnifier or DEFAULT_MAGNIFIER)
    return axial, torsional + 0.5 * (damping.loss_factor or 0.0), bending


Meters: TypeAlias = Annotated[float, Quantity("m")]
# Modes are kept up to this multiple of the highest exciting frequency, and so high superelements are
# made for.
KEPT_FACTOR = 2.0
# Superelements are made for no less than this [Hz], so that the first modes of a slow engine are right.
LEAST_FREQUENCY = 200.0
# The point whose motion is drawn: the free end along the shaft.
FREE_END = "main bearing 1 uz"


# Elastic modes that are listed.
MODES_SHOWN = 12


@result("frequency", "rotation_ratio", eq=True)
class FirstBending(Result):
    """The lowest elastic mode in which bending has the largest share, and the speed over its frequency."""

    frequency: Hertz
    rotation_ratio: Number


@result("modes.frequencies [Hz]", "highest_frequency", "rotation_ratios", "remarks")
class WholeShaft(Result):
    """The whole crankshaft of an engine, its modes, and its assumptions.

    Attributes
    ----------
    highest_frequency : float
        What the superelements were made for [Hz].
    exciting_frequency : float
        Of the highest order at the highest speed [Hz].
    rotation_ratios : (q - r,) array
        Highest ratio of rotational speed to each elastic natural frequency: shows the importance of Coriolis
        forces, which are neglected; see `rotation_ratio`.
    remarks : tuple of str
        Assumptions, a sentence each.
    """

    crankshaft: Internal[CrankshaftSystem]
    highest_frequency: Hertz
    exciting_frequency: Internal[float]
    rotation_ratios: Internal[Array]
    remarks: tuple[str, ...]

    @property
    def modes(self) -> ShaftModes:
        """Natural modes, classified by their shares."""
        return self.crankshaft.modes

    @cached_property
    def listed_modes(self) -> Annotated[tuple[ShaftMode, ...], Quantity(key="modes")]:
        """The first ones, rigid ones included."""
        shown = min(self.modes.rigid + MODES_SHOWN, len(self.modes.names))
        return tuple(map(self.modes.described, range(shown)))

    @cached_property
    def rotation_ratio(self) -> Number:
        """That of the first elastic mode."""
        return float(self.rotation_ratios[0])

    @cached_property
    def bending(self) -> Part[FirstBending | None]:
        """The lowest bending mode, if there is one."""
        first = self.modes.first("bending")
        if first is None:
            return None
        ratio = self.rotation_ratios[first - self.modes.rigid]
        return FirstBending(float(self.modes.frequencies[first]), float(ratio))

    def plot(
        self, axes: Axes | None = None, *, mode: int | None = None, radius: float | None = None
    ) -> Axes:
        """Draw the shape of one mode; see `ShaftModes.plot`."""
        return self.modes.plot(axes, mode=mode, radius=radius)

    def to_pandas(self) -> Any:
        """Return a table of the natural modes; see `ShaftModes.to_pandas`."""
        return self.modes.to_pandas()


@result("tangential", "radial", "both", eq=True)
class AxialSplit(Result):
    """Largest axial amplitude of the free end [m] by either kind of force and by both, each at its speed."""

    tangential: Meters
    tangential_speed: Speed
    radial: Meters
    radial_speed: Speed
    both: Meters
    both_speed: Speed

    @property
    def speed(self) -> Speed:
        """That of the largest by both."""
        return self.both_speed


@result("verdicts")
class ShaftComparison(Result):
    """Coupled vibration of the whole shaft compared with the uncoupled chains of the same engine.

    Attributes
    ----------
    coupled : CoupledResponse or None
        None if nothing is forced.
    axial, torsional : ChainVerdict or None
        None if the chains are not those of the whole shaft; see `not_comparable`.
    differences : tuple of FrequencyDifference
        Causes of the difference between whole shaft and chains, for the first mode of the
        crankshaft itself of each kind, if the whole shaft has a similar one.
    flywheel_tilt : FlywheelTilts or None
        Effect of the flywheel's diametral inertia on the same modes.
    running_range : tuple of two floats
        Speeds [rad/s] within which amplitudes are compared.
    """

    coupled: Internal[CoupledResponse | None]
    axial: Internal[ChainVerdict | None] = None
    torsional: Internal[ChainVerdict | None] = None
    differences: tuple[FrequencyDifference, ...] = ()
    flywheel_tilt: FlywheelTilts | None = None
    running_range: Internal[tuple[float, float]] = (0.0, math.inf)

    @classmethod
    def from_record(cls, content: "Mapping[str, Any] | Self") -> Self:
        """Read content of JSON, in which a chain is of the kind that names it."""
        comparison = super().from_record(content)
        for kind, verdict in comparison.chains.items():
            vars(verdict)["kind"] = kind
        return comparison

    @property
    def verdicts(self) -> tuple[ChainVerdict, ...]:
        """Of the compared chains."""
        return tuple(verdict for verdict in (self.axial, self.torsional) if verdict is not None)

    @cached_property
    def chains(self) -> Part[dict[str, ChainVerdict]]:
        """The same by the kind of vibration."""
        return {verdict.kind: verdict for verdict in self.verdicts}

    @cached_property
    def axial_split(self) -> Part[AxialSplit | None]:
        """Causes of the axial motion; None if nothing is forced."""
        if self.coupled is None:
            return None
        split, speeds = self.coupled.split(FREE_END), self.coupled.speeds
        inside = np.flatnonzero(within(speeds, *self.running_range))
        curves = (split.tangential_sum, split.radial_sum, split.both_sum)
        worst = [int(inside[np.argmax(curve[inside])]) for curve in curves]
        peaks = [(curve[at], speeds[at]) for curve, at in zip(curves, worst, strict=True)]
        return AxialSplit(*(float(part) for peak in peaks for part in peak))

    def plot(
        self,
        axes: Axes | None = None,
        *,
        show: Literal["causes", "axial", "torsional"] = "causes",
        point: str | None = None,
    ) -> Axes:
        """Draw the whole shaft's vibration over the speed, by its causes or with a chain's.

        Parameters
        ----------
        show : {"causes", "axial", "torsional"}
            A point's motion by tangential and by radial forces; or the free end's motion by the whole
            shaft and by the chain of that kind.
        point : str, optional
            Of the first alone, such as "main bearing 1 uz", the free end along the shaft, the default.

        Raises
        ------
        InputError
            If `show` is unknown, or was not calculated, or there is no such point, or one is given
            with a chain.
        """
        check_choice("show", show, ("causes", "axial", "torsional"), "these are compared")
        if show == "causes" and self.coupled is not None:
            return self.coupled.plot(axes, FREE_END if point is None else point)
        if show != "causes":
            check_not_given("point", point, show, "a chain is compared at the free end")
        verdict = {"axial": self.axial, "torsional": self.torsional}.get(show)
        if verdict is None or verdict.response is None:
            raise InputError(
                f"show: given {show!r}; allowed is what was calculated, because without gas pressure "
                "nothing is forced, and a plant's chain of its maker is not compared."
            )
        return verdict.response.plot(axes)

    def to_pandas(self) -> Any:
        """Return a table of the chains' modes and those of the whole shaft."""
        return table_of(match for verdict in self.verdicts for match in verdict.modes)


def whole_shaft(
    engine_file: EngineFile,
    analysis: Analyses,
    *,
    superelement: DynamicSuperelement | None = None,
    bearings: MainBearings | None = None,
) -> WholeShaft:
    """Build the whole crankshaft of an engine from the superelements of its throws.

    Parameters
    ----------
    engine_file : EngineFile
        In line or V. Flywheel, free end, dampers, thrust bearing, driven machine and main bearings come
        from it.
    analysis : ThrowAnalysis or mapping
        Of the engine's throw, or of each throw by its name.
    superelement : DynamicSuperelement, optional
        For shafts of one throw only, to avoid building it; by default one of each throw is
        built for the highest frequency that the engine excites.
    bearings : MainBearings, optional
        Replaces those of the file.

    Raises
    ------
    InputError
        If end sections of the analysis are not rigid, values do not fit, or one superelement is given for
        several throws.
    SolveError
        If the superelement cannot be built.
    """
    check_kind("engine_file", engine_file, EngineFile, "what load_engine returns")
    exciting = highest_exciting_frequency(engine_file)
    highest = max(LEAST_FREQUENCY, exciting)
    each = crank_analyses(engine_file, analysis)
    if superelement is None:
        names = engine_file.throw_names
        built = {
            name: throw_analysis.dynamic_superelement(highest)
            for name, throw_analysis in dict(zip(names, each, strict=True)).items()
        }
        elements = [built[name] for name in names]
    elif len(set(engine_file.crank_throws)) == 1:
        elements = [superelement] * len(each)
    else:
        raise InputError(
            "superelement: given one for several throws; allowed is none, because each throw has its own."
        )
    # Throws side by side share the ring that the mean motion of a section is taken over.
    widest = max(
        (element.sections for element in elements),
        key=lambda section: (section.radius, section.bore),
    )
    throws = [
        throw
        for crank_throw, element, angle_deg in zip(
            engine_file.crank_throws, elements, engine_file.throw_angles_deg, strict=True
        )
        for throw in shaft_throws(
            element.shared_with(widest), crank_throw, crank_angles_deg=[angle_deg]
        )
    ]
    highest = elements[0].highest_frequency
    around, remarks = shaft_surroundings(engine_file, analysis, bearings)
    shaft = assemble_crankshaft(throws, around, turning_sense=engine_file.engine.turning_sense)
    crankshaft = crankshaft_system(shaft, KEPT_FACTOR * highest or None)
    modes = crankshaft.modes
    remarks += damping_remarks(engine_file)
    if len(set(engine_file.pins)) < len(engine_file.pins):
        remarks += (
            "rods on one pin act at its middle; the moment of rods side by side is left out",
        )
    if reason := not_comparable(engine_file):
        remarks += (reason,)
    return WholeShaft(
        crankshaft=crankshaft,
        highest_frequency=highest,
        exciting_frequency=exciting,
        rotation_ratios=rotation_ratio(
            engine_file.engine.highest_speed, modes.angular_frequencies[modes.rigid :]
        ),
        remarks=remarks,
    )


def not_comparable(engine_file: EngineFile) -> str:
    """Say why nothing judges the whole crankshaft of an engine file; nothing if it can be judged."""
    if PLANT in engine_file.shaft_lines:
        return wording.WITHOUT_PLANT
    forces, lines = engine_file.propeller_forces, engine_file.shaft_lines
    if forces is None:
        return ""
    # The propeller's torque and thrust, if there are some, act on a node of the line of their kind.
    acting: tuple[tuple[Kind, Sequence[float]], ...] = (
        ("torsional", forces.torque_shares),
        ("axial", forces.thrust_shares),
    )
    for kind, shares in acting:
        if shares and (kind not in lines or forces.node not in lines[kind].names[1:]):
            return wording.without_propeller(forces.node)
    return ""


def propeller_on_shaft(
    engine_file: EngineFile, whole: WholeShaft, speeds: Array
) -> OrderExcitation | None:
    """Return the varying torque and thrust of a propeller on the shaft line; None without any."""
    propeller_forces, lines = engine_file.propeller_forces, engine_file.shaft_lines
    if propeller_forces is None or not_comparable(engine_file):
        return None
    acting = []
    senses: tuple[tuple[Kind, int], ...] = (
        ("torsional", engine_file.engine.turning_sense),
        ("axial", 1),
    )
    for kind, sense in senses:
        if not (
            propeller_forces.torque_shares
            if kind == "torsional"
            else propeller_forces.thrust_shares
        ):
            continue
        chain = lines[kind]
        node = chain.names.index(propeller_forces.node)
        of_line = propeller_excitation(
            propeller_forces.forces, chain, node, speeds, kind=kind, ratio=propeller_forces.ratio
        )
        forces = np.zeros((*of_line.forces.shape[:2], len(whole.crankshaft.names)), dtype=complex)
        point = whole.crankshaft.point(f"{propeller_forces.node} {MOTION_OF[kind]}")
        forces[:, :, point] = sense * of_line.forces[:, :, node]
        acting.append(replace(of_line, forces=forces))
    return combined_excitation(*acting)


def highest_exciting_frequency(engine_file: EngineFile) -> float:
    """Frequency of the highest order at the highest speed [Hz]."""
    turns = engine_file.engine.highest_speed / (2.0 * math.pi)
    return engine_file.vibration.highest_order * turns


def shaft_throws(
    superelement: DynamicSuperelement, throw: Throw, *, crank_angles_deg: Sequence[float]
) -> list[ShaftThrow]:
    """Return throws at their crank angles, ready to be assembled.

    Parameters
    ----------
    superelement : DynamicSuperelement
        In the throw's own frame, not turned.
    crank_angles_deg : sequence of n float
        Angle of each throw's first pin about +z [deg].
    """
    centers = [[*pin.axis, 0.5 * (pin.start + pin.end)] for pin in throw.parts.pins]
    pins = np.array(centers).reshape(-1, 3)  # an end part of a crankshaft has none
    throws = []
    for angle_deg in map(float, crank_angles_deg):
        turned = superelement.bending_turned(angle_deg=angle_deg)
        throws.append(
            ShaftThrow(
                stiffness=turned.stiffness,
                mass=turned.mass,
                pin_loads=turned.pin_loads,
                pins=pins,
                length=throw.length,
                crank_angle_deg=angle_deg,
                bending=turned.sections.bending,
            )
        )
    return throws


def shaft_response(
    engine_file: EngineFile,
    whole: WholeShaft,
    forces: CylinderForces,
    magnifier: float | None = None,
) -> CoupledResponse:
    """Find the coupled forced vibration of an engine's crankshaft.

    Parameters
    ----------
    forces : CylinderForces
        Of the engine's cylinders, by orders over speeds.
    magnifier : float, optional
        Of all elastic modes, replaces `modal_damping`. Dampers and bearings add theirs.

    Raises
    ------
    SolveError
        If power in and heat do not balance.
    """
    response = coupled_response(
        whole.crankshaft,
        forces,
        pins=engine_file.pins,
        magnifier=magnifier,
        modal_damping=None
        if magnifier is not None
        else modal_damping(engine_file, whole.crankshaft),
        further=propeller_on_shaft(engine_file, whole, forces.speeds),
    )
    for answer in response.parts:
        checked_power_balance(answer)
    return response


def compare_with_chains(
    whole: WholeShaft,
    axial: EngineChain,
    torsional: EngineChain,
    coupled: CoupledResponse | None = None,
    axial_response: ForcedResponse | None = None,
    torsional_response: ForcedResponse | None = None,
    running_range: tuple[float, float] = (0.0, math.inf),
) -> ShaftComparison:
    """Compare the whole shaft with its chains, and decide whether these are adequate.

    Parameters
    ----------
    coupled, axial_response, torsional_response : optional
        Forced vibration under the same forces at the same speeds; by default only modes are compared.
    running_range : tuple of two floats, optional
        Speeds [rad/s] within which the largest amplitudes are compared.

    Returns
    -------
    ShaftComparison
        Modes of the chains up to the highest exciting frequency, and each chain's first mode of the
        crankshaft itself in any case: nothing excites higher ones near their resonance.
    """
    verdicts = []
    for chain, answer in ((axial, axial_response), (torsional, torsional_response)):
        modes = chain.chain.modes()
        first = chain.first_mode(modes)
        highest = whole.highest_frequency if first is None else float(modes.frequencies[first])
        matches = matching_modes(whole.crankshaft, chain, max(highest, whole.exciting_frequency))
        response = None
        if coupled is not None and answer is not None:
            response = matching_response(coupled, chain, answer, running_range)
        verdicts.append(ChainVerdict(matches, response))
    axial_verdict, torsional_verdict = verdicts
    return ShaftComparison(coupled, axial_verdict, torsional_verdict, running_range=running_range)


def with_differences(
    comparison: ShaftComparison,
    whole: WholeShaft,
    chains: tuple[EngineChain, ...],
    rigid_chains: tuple[EngineChain, ...],
) -> ShaftComparison:
    """Add to a comparison the causes of the difference of the crankshaft's first frequencies.

    Parameters
    ----------
    chains, rigid_chains : tuples of EngineChain
        Axial and torsional, in the engine's main bearings and in laterally rigid ones.

    Returns
    -------
    ShaftComparison
        Without a chain whose first mode has no counterpart at every step, or is divided between two;
        unchanged if no chain is compared.
    """
    if not comparison.verdicts:
        return comparison
    shaft, differences = whole.crankshaft.shaft, []
    for chain, rigid in zip(chains, rigid_chains, strict=True):
        modes = chain.chain.modes()
        first = chain.first_mode(modes)
        if first is None:
            continue
        with suppress(InputError):
            differences.append(frequency_difference(shaft, chain, rigid, first - modes.rigid + 1))
    flywheel = None
    if differences:
        inertias = (float(each[-1]) for each in (shaft.stations.diametral, shaft.stations.polar))
        tilts = tuple(difference.tilt for difference in differences)
        flywheel = FlywheelTilts(next(inertias), tilts, next(inertias))
    # Steps lead to one frequency, not to two.
    undivided = tuple(difference for difference in differences if difference.further is None)
    return replace(comparison, differences=undivided, flywheel_tilt=flywheel)


def whole_shaft_remark(comparison: ShaftComparison) -> tuple[str, ...]:
    """Remark on a verdict, which is based on the chains, how the whole crankshaft differs from them.

    Returns
    -------
    tuple of str
        A sentence; none if the chains are adequate.
    """
    differing = [verdict for verdict in comparison.verdicts[::-1] if not verdict.suffices]
    if not differing:
        return ()
    text = wording.differing_chains(list(map(_difference, differing)), differing[0].kind)
    return (finished(text),)


def _difference(verdict: ChainVerdict) -> str:
    """State the main difference: an amplitude, a frequency, else a mode of mixed motion."""
    motion, response = MOTION[verdict.kind], verdict.response
    if response is not None and abs(response.difference) > RESPONSE_LIMIT:
        chain, shaft = (
            f"{amount(peak, motion.si, 3, zeros=True, shown=motion.printed)} at "
            f"{amount(speed, 'rad/s', 3, zeros=True)}"
            if np.isfinite(peak)
            else UNBOUNDED
            for speed, peak in response.peaks
        )
        return wording.differing_amplitude(verdict.kind, shaft, chain)
    for match in verdict.modes:
        if match.divided or not abs(match.difference) <= FREQUENCY_LIMIT:
            return wording.differing_mode(
                verdict.kind,
                match.chain_mode - match.chain_rigid + 1,
                match.chain_frequency,
                match.shaft_frequency,
                [frequency for frequency, _ in match.divided],
            )
    mixed = min(verdict.modes, key=lambda match: match.share)
    return wording.impure_mode(verdict.kind, mixed.shaft_frequency, mixed.share)
