"""A whole crankshaft beside its uncoupled chains, and whether the chains suffice."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import Row, table, table_of
from dynamics.chains.engine_chains import EngineChain, Kind
from dynamics.crankshaft.assembly import AssembledShaft
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.crankshaft.shaft_modes import CRANKSHAFT_MODE, ShaftModes
from dynamics.crankshaft.shaft_system import CrankshaftSystem
from dynamics.crankshaft.shaft_throw import RZ, UZ
from dynamics.crankshaft.stations import CLASSES
from dynamics.plots.quantities import in_unit
from dynamics.plots.speed_curves import draw_named_curves
from dynamics.response.forced import ForcedResponse
from dynamics.response.synthesis import synthesis

# A chain suffices where its frequencies, the purity of the modes and the free end's amplitude are within
# these. 3 % of frequency is what compliances from finite elements are worth; a share of 95 % leaves at
# most 5 % of a mode's energy to motion that the chain does not know; 10 % of amplitude is less than the
# uncertainty of any damping.
FREQUENCY_LIMIT = 0.03
SHARE_LIMIT = 0.95
RESPONSE_LIMIT = 0.10
# A mode of the shaft is looked for within this factor of the chain's frequency.
SEARCHED = 2.0


@summarized(
    "kind", "chain_frequency [Hz]", "shaft_frequency [Hz]", "difference", "share", "likeness"
)
@dataclass(frozen=True)
class ModeMatch:
    """A mode of a chain and the mode of the whole shaft that is most like it.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    chain_mode : int
        Among all modes of the chain, rigid ones included.
    chain_frequency : float
        [Hz]
    shaft_mode : int or None
        Among all modes of the shaft, rigid ones included; None if none is near.
    shaft_frequency : float or None
        [Hz]
    share : float
        Of the shaft mode's energy that is of this kind.
    likeness : float
        Squared cosine, weighted by the chain's inertias, between both shapes; 1 for the same.
    chain_rigid, shaft_rigid : int
        Number of rigid modes of either; tables count elastic modes from 1.
    """

    kind: Kind
    chain_mode: int
    chain_frequency: float
    shaft_mode: int | None
    shaft_frequency: float | None
    share: float
    likeness: float
    chain_rigid: int = 0
    shaft_rigid: int = 0

    @property
    def difference(self) -> float:
        """Frequency of the chain over that of the shaft, less 1; inf if there is no match."""
        if self.shaft_frequency is None:
            return np.inf
        return self.chain_frequency / self.shaft_frequency - 1.0

    def row(self) -> Row:
        """Return what a table of matches shows, each value with its unit; see `table_of`.

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


@summarized("kind", "speeds [rad/s]", "chain", "shaft", "difference")
@dataclass(frozen=True, eq=False)
class ResponseMatch:
    """Amplitude of the free end by a chain and by the whole shaft.

    Half of the range over the working cycle, all orders together, motion of the rigid body left out.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    speeds : (S,) array
        [rad/s]
    chain, shaft : (S,) array
        [m or rad]; inf where unbounded.
    """

    kind: Kind
    speeds: FloatArray
    chain: FloatArray
    shaft: FloatArray

    @property
    def difference(self) -> float:
        """Largest amplitude by the chain over that of the shaft, less 1."""
        chain, shaft = float(np.max(self.chain)), float(np.max(self.shaft))
        if chain == shaft:
            return 0.0
        return chain / shaft - 1.0 if 0.0 < shaft < np.inf else np.inf

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the amplitude of the free end by the chain and by the whole shaft over the speed.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; those of a new figure if not given.

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

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        unit = "m" if self.kind == "axial" else "rad"
        return table(
            {
                "speed": (self.speeds, "rad/s"),
                "chain": (self.chain, unit),
                "shaft": (self.shaft, unit),
            }
        )


@summarized("kind", "suffices", "reasons", "modes")
@dataclass(frozen=True)
class ChainVerdict:
    """Whether a chain suffices in place of the whole shaft.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    suffices : bool
    reasons : tuple of str
        Why not, a sentence each; empty if it does.
    modes : tuple of ModeMatch
        That were looked at.
    response : ResponseMatch or None
    """

    kind: Kind
    suffices: bool
    reasons: tuple[str, ...]
    modes: tuple[ModeMatch, ...]
    response: ResponseMatch | None

    def to_pandas(self) -> DataFrame:
        """Return a row for each mode that was compared; amplitudes are in ``response``.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.modes)


def matching_modes(
    crankshaft: CrankshaftSystem, chain: EngineChain, highest_frequency: float
) -> tuple[ModeMatch, ...]:
    """Find for each mode of the crankshaft in a chain the mode of the whole shaft that is most like it.

    Modes of a coupling, a damper's ring or a shaft line, in whose elements more than half of the strain
    energy is, say nothing of the crankshaft and are left out.

    Parameters
    ----------
    crankshaft : CrankshaftSystem
    chain : EngineChain
        Axial or torsional, of the same throws.
    highest_frequency : float
        Up to which modes of the chain are looked at [Hz].

    Returns
    -------
    tuple of ModeMatch
        Of the mode with the largest product of share and likeness.

    Raises
    ------
    InputError
        If the chain has another number of throws, or the frequency is not above zero.
    """
    positive_number("highest_frequency", highest_frequency, "Hz", "modes are compared up to it")
    modes = chain.chain.modes()
    own = chain.crankshaft_shares(modes) >= CRANKSHAFT_MODE
    wanted = np.flatnonzero(own & (modes.frequencies <= highest_frequency))
    wanted = wanted[wanted >= modes.rigid].tolist()
    return match_modes(crankshaft.shaft, crankshaft.modes, chain, wanted)


def match_modes(
    shaft: AssembledShaft, modes: ShaftModes, chain: EngineChain, wanted: Sequence[int]
) -> tuple[ModeMatch, ...]:
    """Find for some modes of a chain those of the whole shaft that are most like them.

    Parameters
    ----------
    shaft : AssembledShaft
    modes : ShaftModes
        Of that shaft.
    chain : EngineChain
    wanted : sequence of int
        Modes of the chain, rigid ones counted.

    Returns
    -------
    tuple of ModeMatch

    Raises
    ------
    InputError
        If the chain has another number of throws.
    """
    if chain.throws != shaft.section_count - 1:
        raise InputError(
            f"chain: given one of {chain.throws} throws; allowed is one of {shaft.section_count - 1}, "
            "because the shaft has so many."
        )
    nodes = list(chain.sections if chain.kind == "axial" else chain.throw_nodes)
    moved = _motion_of_nodes(shaft, modes, chain.kind)
    share = modes.shares[CLASSES.index(chain.kind)]
    weight = chain.chain.inertia[nodes]
    sizes = weight @ moved**2
    chain_modes = chain.chain.modes()
    rigid = chain_modes.rigid, modes.rigid
    found = []
    for number in wanted:
        frequency = float(chain_modes.frequencies[number])
        shape = chain_modes.shapes[nodes, number]
        likeness = (weight * shape) @ moved
        likeness = likeness**2 / np.where(sizes > 0.0, sizes, 1.0) / (weight @ shape**2)
        near = (modes.frequencies >= frequency / SEARCHED) & (
            modes.frequencies <= frequency * SEARCHED
        )
        score = np.where(near, share * likeness, 0.0)
        best = int(np.argmax(score))
        match: tuple[int | None, float | None, float, float] = (None, None, 0.0, 0.0)
        if score[best] > 0.0:
            here = float(modes.frequencies[best])
            match = (best, here, float(share[best]), float(likeness[best]))
        found.append(ModeMatch(chain.kind, number, frequency, *match, *rigid))
    return tuple(found)


def matching_response(
    coupled: CoupledResponse, chain: EngineChain, answer: ForcedResponse
) -> ResponseMatch:
    """Compare the free end's amplitude by a chain with that by the whole shaft.

    Parameters
    ----------
    coupled : CoupledResponse
    chain : EngineChain
    answer : ForcedResponse
        Of the chain, under the same forces.

    Returns
    -------
    ResponseMatch

    Raises
    ------
    InputError
        If orders or speeds differ.
    """
    same = np.array_equal(coupled.orders, answer.orders) and np.array_equal(
        coupled.speeds, answer.speeds
    )
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
        shaft=coupled.split("section 0 uz" if axial else "section 0 rz").both_sum,
    )


def chain_verdict(
    modes: Sequence[ModeMatch], response: ResponseMatch | None = None
) -> ChainVerdict:
    """Say whether a chain suffices.

    Parameters
    ----------
    modes : sequence of ModeMatch
        From `matching_modes`, of one kind.
    response : ResponseMatch, optional

    Returns
    -------
    ChainVerdict

    Raises
    ------
    InputError
        If there is no mode.

    Notes
    -----
    The criterion: every mode of the chain within the frequencies of interest has its match within 3 %, of
    which 95 % of the energy are of the chain's kind, and the largest amplitude of the free end over the
    speeds agrees within 10 %.
    """
    if not modes:
        raise InputError(
            "modes: given none; allowed is one or more, because a chain is judged by its modes."
        )
    kind = modes[0].kind
    reasons = []
    for match in modes:
        name = f"{kind} mode of the chain at {match.chain_frequency:.1f} Hz"
        if match.shaft_frequency is None:
            reasons.append(f"The {name} has none like it in the whole shaft.")
            continue
        if abs(match.difference) > FREQUENCY_LIMIT:
            reasons.append(
                f"The {name} lies {100.0 * match.difference:+.1f} % from that of the whole shaft at "
                f"{match.shaft_frequency:.1f} Hz, more than {100.0 * FREQUENCY_LIMIT:.0f} %."
            )
        if match.share < SHARE_LIMIT:
            reasons.append(
                f"The whole shaft's mode at {match.shaft_frequency:.1f} Hz is {kind} by "
                f"{100.0 * match.share:.0f} % only, less than {100.0 * SHARE_LIMIT:.0f} %."
            )
    if response is not None and abs(response.difference) > RESPONSE_LIMIT:
        reasons.append(
            f"The largest {kind} amplitude of the free end differs by "
            f"{100.0 * response.difference:+.0f} % from that of the whole shaft, more than "
            f"{100.0 * RESPONSE_LIMIT:.0f} %."
        )
    return ChainVerdict(kind, not reasons, tuple(reasons), tuple(modes), response)


def _motion_of_nodes(shaft: AssembledShaft, modes: ShaftModes, kind: Kind) -> FloatArray:
    """Return how each mode moves the sections along the shaft, or turns the throws, (nodes, q)."""
    motions = modes.motions
    sections = shaft.section_count
    if kind == "axial":
        return np.asarray(motions[:sections, UZ])
    throws = np.array(shaft.pin_throws)
    turns = motions[sections : sections + len(throws), RZ]
    return np.array([turns[throws == throw].mean(axis=0) for throw in np.unique(throws)])
