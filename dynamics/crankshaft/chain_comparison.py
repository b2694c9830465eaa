"""A whole crankshaft compared with its chains: modes, causes of differences, whether chains suffice."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array, Integers, positive_number
from crankbase.choices import check_some, whole_within
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, Row, table, table_of
from crankbase.results import Hertz, Internal, Number, Part, Quantity, Result, result
from dynamics import wording
from dynamics.chains.engine_chains import CRANKSHAFT_MODE, FLYWHEEL, FREE_END, EngineChain, Kind
from dynamics.crankshaft.assembly import BENDING, CLASSES, MOTION_OF, AssembledShaft, Stations
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.crankshaft.shaft_modes import CrankshaftSystem, ShaftModes, crankshaft_modes
from dynamics.crankshaft.surroundings import RX, RY, RZ, UZ
from dynamics.indices import within
from dynamics.plots.curves import draw_named_curves, in_unit
from dynamics.response.forced import ForcedResponse
from dynamics.response.series import synthesis

# A mode of the shaft is looked for within this factor of the chain's frequency.
SEARCHED = 2.0
# A second mode shares the chain's mode where share times likeness is at least this.
DIVIDED = 0.25


@result("kind", "chain_frequency", "shaft_frequency", "difference", "share", "likeness", eq=True)
class ModeMatch(Result):
    """A mode of a chain and the most similar mode of the whole shaft.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    chain_mode : int
        Among all modes of the chain, rigid ones included.
    chain_frequency : float
        [Hz]
    shaft_mode : int or None
        Among all modes of the shaft, rigid ones included; None if there is none near.
    shaft_frequency : float or None
        [Hz]
    share : float
        Share of the shaft mode's energy of this kind.
    likeness : float
        Squared cosine, weighted by the chain's masses, between both shapes; 1 for the same.
    chain_rigid, shaft_rigid : int
        Number of rigid modes of either; tables count elastic modes from 1.
    further_frequency : float or None
        Of the shaft's second mode alike [Hz], where coupling divides the chain's mode between two: of the
        energy of its motion, at least a quarter is that of the chain's mode. None where there is none.
    further_share : float
        Of that mode's energy that is of this kind.
    """

    kind: Internal[Kind]
    chain_mode: Internal[int]
    chain_frequency: Hertz
    shaft_mode: Internal[int | None]
    shaft_frequency: Hertz | None
    share: Number
    likeness: Number
    chain_rigid: Internal[int] = 0
    shaft_rigid: Internal[int] = 0
    further_frequency: Hertz | None = None
    further_share: Number = 0.0

    @property
    def divided(self) -> tuple[tuple[float, float], ...]:
        """Frequencies [Hz] and shares of the two modes that a chain's mode is divided between, or none."""
        if self.shaft_frequency is None or self.further_frequency is None:
            return ()
        both = ((self.shaft_frequency, self.share), (self.further_frequency, self.further_share))
        return tuple(sorted(both))

    @property
    def difference(self) -> float:
        """Frequency of the chain over that of the shaft, minus 1; inf if there is no match."""
        if self.shaft_frequency is None:
            return np.inf
        return self.chain_frequency / self.shaft_frequency - 1.0

    def row(self) -> Row:
        """Return the columns of a table of matches, each value with its unit; see `table_of`.

        Elastic modes are counted from 1: ``mode`` is that of the chain, as in all tables of a chain,
        and ``shaft_mode`` that of the whole shaft.
        """
        shaft = None if self.shaft_mode is None else self.shaft_mode - self.shaft_rigid + 1
        return {
            "kind": (self.kind, ""),
            "mode": (self.chain_mode - self.chain_rigid + 1, "1"),
            "chain_frequency": (self.chain_frequency, "Hz"),
            "shaft_mode": (shaft, "1"),
            "shaft_frequency": (self.shaft_frequency, "Hz"),
            "share": (self.share, "1"),
            "likeness": (self.likeness, "1"),
            "difference": (self.difference, "1"),
        }


def matching_modes(
    crankshaft: CrankshaftSystem, chain: EngineChain, highest_frequency: float
) -> tuple[ModeMatch, ...]:
    """Find for each mode of the crankshaft in a chain the most similar mode of the whole shaft.

    Modes of a coupling, a damper's ring or a shaft line, with more than half of the strain energy
    in its elements, do not concern the crankshaft and are left out.

    Parameters
    ----------
    chain : EngineChain
        Axial or torsional, of the same throws.
    highest_frequency : float
        Highest frequency of the chain's modes considered [Hz].

    Returns
    -------
    tuple of ModeMatch
        As `match_modes`.
    """
    positive_number("highest_frequency", highest_frequency, "Hz", "modes are compared up to it")
    modes = chain.chain.modes()
    of_cranks = chain.crankshaft_shares(modes) >= CRANKSHAFT_MODE
    wanted = np.flatnonzero(of_cranks & (modes.frequencies <= highest_frequency))
    wanted = wanted[wanted >= modes.rigid].tolist()
    return match_modes(crankshaft.shaft, crankshaft.modes, chain, wanted)


def match_modes(
    shaft: AssembledShaft, modes: ShaftModes, chain: EngineChain, wanted: Sequence[int]
) -> tuple[ModeMatch, ...]:
    """Find for some modes of a chain the most similar modes of the whole shaft.

    Arguments are those of `mode_likeness`. The products of share and likeness are largest in all; no mode of
    the shaft stands for two.
    """
    from scipy.optimize import linear_sum_assignment  # here: loading it takes long

    share = modes.shares[CLASSES.index(chain.kind)]
    likeness = mode_likeness(shaft, modes, chain, wanted)
    scores = share * likeness
    chain_modes = chain.chain.modes()
    rigid, matches = (chain_modes.rigid, modes.rigid), []
    taken = linear_sum_assignment(scores, maximize=True)[1].tolist()
    others = scores.copy()
    others[:, taken] = 0.0
    for row, (number, best) in enumerate(zip(wanted, taken, strict=True)):
        match: tuple[int | None, float | None, float, float] = (None, None, 0.0, 0.0)
        if scores[row, best] > 0.0:
            here = float(modes.frequencies[best])
            match = (best, here, float(share[best]), float(likeness[row, best]))
        second = int(np.argmax(others[row]))
        further: tuple[float | None, float] = (None, 0.0)
        if others[row, second] >= DIVIDED:
            further = (float(modes.frequencies[second]), float(share[second]))
        frequency = float(chain_modes.frequencies[number])
        matches.append(ModeMatch(chain.kind, number, frequency, *match, *rigid, *further))
    return tuple(matches)


def mode_likeness(
    shaft: AssembledShaft, modes: ShaftModes, chain: EngineChain, wanted: Sequence[int]
) -> Array:
    """Return how much each mode of the whole shaft moves the chain's nodes as the chain's modes do.

    Parameters
    ----------
    modes : ShaftModes
        Of that shaft.
    wanted : sequence of w int
        Modes of the chain, rigid ones counted.

    Returns
    -------
    ndarray of shape (w, q)
        Squared cosine between both shapes, weighted by the chain's masses; 0 beyond twice the frequency
        of the chain's mode and below half of it.
    """
    if chain.throws != shaft.section_count - 1:
        raise InputError(
            f"chain: given one of {chain.throws} throws; allowed is one of {shaft.section_count - 1}, "
            "because the shaft has so many."
        )
    # How each mode moves the chain's nodes that the shaft has too, along or about it: throws, ends, damper
    # ring, driven machine and shaft line. Without these a mode of the ring resembles one of the crankshaft,
    # whose throws it moves alike.
    motions, sections = modes.motions, shaft.section_count
    names = shaft.names[len(shaft.names) - len(shaft.added) :]
    added = dict(zip(names, shaft.added @ modes.shapes, strict=True))
    if chain.kind == "axial":
        of_node, ends = dict(zip(chain.sections, motions[:sections, UZ], strict=True)), {}
    else:
        pins = np.array(shaft.pin_throws)
        turns = motions[sections : sections + len(pins), RZ]
        throws = (turns[pins == throw].mean(axis=0) for throw in np.unique(pins))
        of_node = dict(zip(chain.throw_nodes, throws, strict=True))
        ends = {FREE_END: motions[0, RZ], FLYWHEEL: motions[sections - 1, RZ]} | added
    for node, name in enumerate(chain.nodes):
        beside = ends.get(name, added.get(f"{name} {MOTION_OF[chain.kind]}"))
        if node not in of_node and beside is not None:
            of_node[node] = beside
    nodes, moved = list(of_node), np.array(list(of_node.values()))
    weight = chain.chain.mass_matrix()[np.ix_(nodes, nodes)]
    sizes = np.sum(moved * (weight @ moved), axis=0)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    chain_modes = chain.chain.modes()
    likeness = np.zeros((len(wanted), modes.frequencies.size))
    for row, number in enumerate(wanted):
        frequency, shape = (
            chain_modes.frequencies[number],
            weight @ chain_modes.shapes[nodes, number],
        )
        near = within(modes.frequencies, frequency / SEARCHED, frequency * SEARCHED)
        cosines = (shape @ moved) ** 2 / sizes / (shape @ chain_modes.shapes[nodes, number])
        likeness[row] = np.where(near, cosines, 0.0)
    return likeness


def followed_modes(masses: Array, shapes: Sequence[Array]) -> Integers:
    """Follow modes by their shapes from one shaft to the next of the same masses.

    Parameters
    ----------
    masses : ndarray of shape (u, u)
    shapes : sequence of k ndarrays of shape (u, m)
        Modes of unit modal mass of shafts that differ little from one to the next.

    Returns
    -------
    ndarray of shape (k, m)
        Row by row the mode of each shaft that follows mode 0, 1 ... of the first one: each once, with
        the largest sum of squared products of shapes, weighted by the masses.
    """
    from scipy.optimize import linear_sum_assignment  # here: loading it takes long

    rows = [np.arange(shapes[0].shape[1])]
    for before, after in pairwise(shapes):
        alike = (before.T @ masses @ after) ** 2
        rows.append(linear_sum_assignment(alike, maximize=True)[1][rows[-1]])
    return np.array(rows)


# Share of the shaft's own mass matrix that stays in every step: without any mass a motion has no frequency.
RESIDUAL = 1e-6
# Causes of less are not told [Hz]: they print as nothing.
SHOWN = 0.05
# In the order of the steps, each added to those before it; the last one is a body's of its own.
CAUSES = ("bearings", "mass distribution", "lateral inertia", "eccentric masses", "flywheel tilt")
# Behind the name of the step that a shaft line's bending stiffness comes in, too.
LINE_TOO = " and bending of the line"


@result("kind", "rigid_chain", "chain", "shaft", "causes", eq=True)
class FrequencyDifference(Result):
    """A mode's frequency in the chain and in the whole crankshaft, and the steps from one to the other.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    mode : int
        Elastic mode of the chain, from 1.
    rigid_chain : float
        Frequency of the chain in laterally rigid bearings [Hz].
    chain, shaft : float
        In the engine's bearings: of the chain, and of the whole crankshaft [Hz].
    causes : dict of str to float
        Contributions to the frequency [Hz]; their sum with `rigid_chain` is `shaft`. "bearings":
        lateral motion of the journals. "mass distribution": inertia along each throw in place of lumps, and
        inertia loads within the shaft, which the journals' reactions carry from throw to throw; with a shaft
        line that bends, how it holds the flywheel, too.
        "lateral inertia": that of the throws as if centered on the axis, and of the end bodies without the
        flywheel's diametral inertia. "eccentric masses": the throws' centers of mass off the axis.
        "flywheel tilt": the flywheel's diametral inertia resists the tilting of its section.
    further : float or None
        Of a second mode that the shaft divides the chain's into [Hz]: the steps lead to the first alone.
    """

    kind: str
    mode: int
    rigid_chain: Hertz
    chain: Hertz
    shaft: Hertz
    causes: Annotated[dict[str, float], Quantity("Hz")]
    further: Internal[float | None] = None

    @cached_property
    def sentence(self) -> Part[str]:
        """Such as "axial mode 1: 81.0 Hz by the whole crankshaft, 75.0 Hz by the chain (+6.0 Hz, ...)".

        Causes of less than 0.05 Hz, and what rounding leaves, are told together, so that what is
        printed adds up.
        """
        steps = {name: by for name, by in self.causes.items() if name != CAUSES[0]}
        return wording.frequency_steps(self.kind, self.mode, self.shaft, self.chain, steps, SHOWN)

    @property
    def tilt(self) -> "FlywheelTilt":
        """The last step: the effect of the flywheel's diametral inertia, which is often assumed."""
        without = self.shaft - self.causes[CAUSES[-1]]
        return FlywheelTilt(self.kind, self.mode, without, self.shaft, self.further)

    @property
    def largest(self) -> str:
        """Cause with the largest effect on the frequency."""
        return max(self.causes, key=lambda name: abs(self.causes[name]))


def frequency_difference(
    shaft: AssembledShaft, chain: EngineChain, rigid_chain: EngineChain, mode: int = 1
) -> FrequencyDifference:
    """Split the difference between a chain's frequency and that of the whole crankshaft.

    Parameters
    ----------
    chain : EngineChain
        With the throws' compliances in the same bearings.
    rigid_chain : EngineChain
        With those in laterally rigid bearings.
    mode : int
        Elastic mode of the chain, from 1.

    Raises
    ------
    InputError
        If the chain has no such mode, or the whole crankshaft has none similar to it.

    Notes
    -----
    Masses are added one kind after another, and the mode most similar to the chain's is followed. The
    contribution of a cause depends on the order of the steps; the sum does not. The flywheel, the last
    station, gets its diametral inertia last, so that its contribution is what a wrong value can change.
    """
    frequencies = [_elastic(rigid_chain, mode), _elastic(chain, mode)]
    stations: Stations = shaft.stations
    for lateral in (False, True):
        # All mass on the shaft axis, then across it too, but for the diametral inertia of the last station.
        across = lateral * stations.lateral_mass
        tilting = lateral * np.append(stations.diametral[:-1], 0.0)
        diagonal = np.column_stack(
            (across, across, stations.axial_mass, tilting, tilting, stations.polar)
        )
        centered = np.einsum("siu,si,siv->uv", stations.motions, diagonal, stations.motions)
        added = shaft.added_mass[: len(CLASSES) - 1 + lateral].sum(axis=0)
        on_axis = (1.0 - RESIDUAL) * (centered + added)
        changed = replace(shaft, mass=on_axis + RESIDUAL * shaft.mass)
        frequencies.append(_found(_match(changed, chain, mode)))
    tilts = stations.motions[-1, [RX, RY]]
    light = replace(shaft, mass=shaft.mass - stations.diametral[-1] * tilts.T @ tilts)
    last = _match(shaft, chain, mode)
    causes = list(CAUSES)
    if np.any(shaft.spring_kinds == BENDING):
        causes[1] += LINE_TOO
    frequencies += [_found(_match(light, chain, mode)), _found(last)]
    return FrequencyDifference(
        kind=chain.kind,
        mode=mode,
        rigid_chain=frequencies[0],
        chain=frequencies[1],
        shaft=frequencies[-1],
        causes=dict(zip(causes, np.diff(frequencies).tolist(), strict=True)),
        further=last.further_frequency,
    )


@result("kind", "mode", "without", "shaft", eq=True)
class FlywheelTilt(Result):
    """Effect of the flywheel's diametral inertia on a mode of the whole crankshaft.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    mode : int
        Elastic mode of the chain, from 1, that matches the mode.
    without, shaft : float
        Frequency without this inertia, and with that of the shaft [Hz].
    further : float or None
        Second frequency with it, where it divides the mode between two [Hz].
    """

    kind: str
    mode: int
    without: Hertz
    shaft: Hertz
    further: Hertz | None = None

    @property
    def shown(self) -> bool:
        """Whether the inertia moves the frequency by 0.05 Hz or more."""
        return abs(self.shaft - self.without) >= SHOWN

    @property
    def sentence(self) -> str:
        """For example "torsional mode 1 from 75.0 Hz without to 84.0 Hz with it"."""
        frequencies = sorted(filter(None, (self.shaft, self.further)))
        # Inertia raises no frequency in its place of the row: a mode told higher has changed places.
        passed = self.shown and self.further is None and self.shaft > self.without
        return wording.tilted_mode(self.kind, self.mode, self.without, frequencies, passed)


@result("inertia", "modes", eq=True)
class FlywheelTilts(Result):
    """Effect of a flywheel's diametral inertia on the first modes.

    Attributes
    ----------
    modes : tuple of FlywheelTilt
        One or more.
    polar : float
        Inertia about the shaft [kg m^2].
    """

    inertia: Annotated[float, Quantity("kg m^2", "about a diameter")]
    modes: tuple[FlywheelTilt, ...]
    polar: Internal[float]

    @cached_property
    def sentence(self) -> Part[str]:
        """The inertia and which modes it moves, without its unit's place."""
        moved = [tilt.sentence for tilt in self.modes if tilt.shown]
        return wording.flywheel_tilts(
            self.inertia, bool(np.isclose(self.inertia, 0.5 * self.polar)), moved
        )


def _elastic(chain: EngineChain, mode: int) -> float:
    frequencies = chain.chain.modes().elastic_frequencies
    whole_within("mode", mode, 1, len(frequencies), "the chain has so many elastic modes")
    return float(frequencies[mode - 1])


def _match(shaft: AssembledShaft, chain: EngineChain, mode: int) -> ModeMatch:
    number = chain.chain.modes().rigid + mode - 1
    return match_modes(shaft, crankshaft_modes(shaft), chain, [number])[0]


def _found(match: ModeMatch) -> float:
    if match.shaft_frequency is None:
        number = match.chain_mode - match.chain_rigid + 1
        raise InputError(
            f"mode: given {number}, {match.chain_frequency:.1f} Hz; allowed is one that the whole crankshaft "
            "has too, and none of its modes is like it."
        )
    return match.shaft_frequency


# A chain suffices where its frequencies, the purity of the modes and the free end's amplitude are within
# these. 3 % of frequency is what compliances from finite elements are worth; a share of 95 % leaves at
# most 5 % of a mode's energy to motion that the chain does not know; 10 % of amplitude is less than the
# uncertainty of any damping.
FREQUENCY_LIMIT = 0.03
SHARE_LIMIT = 0.95
RESPONSE_LIMIT = 0.10


@result("kind", "speeds [rad/s]", "chain", "shaft", "difference")
class ResponseMatch:
    """Amplitude of the free end by a chain and by the whole shaft.

    Half of the range over the working cycle, all orders together, without rigid-body motion.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    speeds : (S,) array
        [rad/s]
    chain, shaft : (S,) array
        [m or rad]; inf where unbounded.
    running_range : tuple of two floats
        Speeds [rad/s] within which the largest amplitudes are compared; all by default.
    """

    kind: Kind
    speeds: Array
    chain: Array
    shaft: Array
    running_range: tuple[float, float] = (0.0, np.inf)

    @property
    def peaks(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Speed [rad/s] and size [m or rad] of the largest amplitude: by the chain, and by the shaft.

        Each at its own worst speed of the running range.
        """
        inside = np.flatnonzero(within(self.speeds, *self.running_range))
        worst = [int(inside[np.argmax(curve[inside])]) for curve in (self.chain, self.shaft)]
        return (
            (float(self.speeds[worst[0]]), float(self.chain[worst[0]])),
            (float(self.speeds[worst[1]]), float(self.shaft[worst[1]])),
        )

    @property
    def difference(self) -> float:
        """Largest amplitude by the chain over that of the shaft, less 1."""
        (_, chain), (_, shaft) = self.peaks
        if chain == shaft:
            return 0.0
        return chain / shaft - 1.0 if 0.0 < shaft < np.inf else np.inf

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the amplitude of the free end by the chain and by the whole shaft over the speed.

        Returns
        -------
        matplotlib.axes.Axes
            Curves have gaps where the vibration is unbounded.
        """
        drawn = in_unit("m" if self.kind == "axial" else "rad")
        curves = {"whole shaft": drawn.factor * self.shaft, "chain": drawn.factor * self.chain}
        title = f"{self.kind} vibration of the free end, all orders together"
        return draw_named_curves(axes, self.speeds, curves, drawn.label, title=title, dashed=True)

    def to_pandas(self) -> DataFrame:
        """Return a row for each speed: amplitude by the chain and by the shaft.

        Units and errors are those of `crankbase.frames.table`.
        """
        unit = "m" if self.kind == "axial" else "rad"
        return table(
            {
                "speed": (self.speeds, "rad/s"),
                "chain": (self.chain, unit),
                "shaft": (self.shaft, unit),
            }
        )


@result("kind", "suffices", "reasons", "modes")
class ChainVerdict(Result):
    """Whether a chain is an adequate model of the whole shaft.

    Every mode of the chain within the frequencies of interest has a match within 3 %, with at least 95 % of
    its energy of the chain's kind, and the largest amplitude of the free end at running speeds agrees
    within 10 %.

    Attributes
    ----------
    modes : tuple of ModeMatch
        The modes compared, one or more of one kind.
    response : ResponseMatch or None
        None if only modes are compared.
    """

    modes: tuple[ModeMatch, ...]
    response: Internal[ResponseMatch | None] = None

    def __post_init__(self) -> None:
        check_some("modes", self.modes, "a chain is judged by its modes")

    @cached_property
    def kind(self) -> Kind:
        """Of the vibration, "axial" or "torsional"."""
        return self.modes[0].kind

    @property
    def unit(self) -> str:
        """Of the amplitudes."""
        return "m" if self.kind == "axial" else "rad"

    @cached_property
    def reasons(self) -> Part[tuple[str, ...]]:
        """Why it is inadequate, a sentence each; empty if it is adequate."""
        reasons = []
        for match in self.modes:
            name, shaft = (
                wording.chain_mode(self.kind, match.chain_frequency),
                match.shaft_frequency,
            )
            if shaft is None:
                reasons.append(wording.no_mode_alike(name))
            elif match.divided:
                reasons.append(wording.two_modes_alike(name, self.kind, match.divided))
            else:
                if abs(match.difference) > FREQUENCY_LIMIT:
                    reasons.append(
                        wording.other_frequency(name, shaft, match.difference, FREQUENCY_LIMIT)
                    )
                if match.share < SHARE_LIMIT:
                    reasons.append(wording.mixed_mode(self.kind, shaft, match.share, SHARE_LIMIT))
        if self.response is not None and abs(self.response.difference) > RESPONSE_LIMIT:
            reasons.append(
                wording.other_amplitude(self.kind, self.response.difference, RESPONSE_LIMIT)
            )
        return tuple(reasons)

    @cached_property
    def suffices(self) -> Part[bool]:
        """Whether it is adequate."""
        return not self.reasons

    def _peak(self, by: int, part: int) -> float | None:
        peak = np.inf if self.response is None else self.response.peaks[by][part]
        return peak if np.isfinite(peak) else None

    @cached_property
    def chain_amplitude(self) -> Annotated[float | None, Quantity(".unit")]:
        """Largest of the free end at running speeds, by the chain; None where unbounded or unknown."""
        return self._peak(0, 1)

    @cached_property
    def chain_speed(self) -> Annotated[float | None, Quantity("rad/s", exported="1/min")]:
        """That of this amplitude."""
        return self._peak(0, 0)

    @cached_property
    def shaft_amplitude(self) -> Annotated[float | None, Quantity(".unit")]:
        """The same by the whole shaft."""
        return self._peak(1, 1)

    @cached_property
    def shaft_speed(self) -> Annotated[float | None, Quantity("rad/s", exported="1/min")]:
        """That of this amplitude."""
        return self._peak(1, 0)

    def to_pandas(self) -> DataFrame:
        """Return a row for each mode that was compared; amplitudes are in ``response``.

        Units and errors are those of `crankbase.frames.table`.
        """
        return table_of(self.modes)


def matching_response(
    coupled: CoupledResponse,
    chain: EngineChain,
    answer: ForcedResponse,
    running_range: tuple[float, float] = (0.0, np.inf),
) -> ResponseMatch:
    """Compare the free end's amplitude by a chain with that by the whole shaft.

    Parameters
    ----------
    answer : ForcedResponse
        Of the chain, under the same forces.
    running_range : tuple of two floats, optional
        As in `ResponseMatch`.
    """
    same = np.array_equal(coupled.speeds, answer.speeds)
    if coupled.further is None:
        same = same and np.array_equal(coupled.orders, answer.orders)
    if not same:
        raise InputError(
            f"answer: given {answer.orders.size} orders at {answer.speeds.size} speeds; allowed are the "
            "orders and speeds of the shaft's response, because amplitudes are compared one by one."
        )
    axial = chain.kind == "axial"
    # The free end's node comes first in either chain, before the first throw's.
    node = chain.sections[0] if axial else 0
    elastic = answer.elastic
    by_chain = synthesis(answer.orders, answer.speeds, elastic.values[:, :, node], answer.unbounded)
    return ResponseMatch(
        kind=chain.kind,
        speeds=coupled.speeds,
        chain=by_chain.amplitude,
        shaft=coupled.split("main bearing 1 uz" if axial else "main bearing 1 rz").both_sum,
        running_range=running_range,
    )
