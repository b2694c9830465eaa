"""Which modes of a whole crankshaft correspond to those of its chains."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import Row
from dynamics.chains.engine_chains import CRANKSHAFT_MODE, FLYWHEEL, FREE_END, EngineChain, Kind
from dynamics.crankshaft.assembly import AssembledShaft
from dynamics.crankshaft.joined_lines import MOTION_OF
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.crankshaft.shaft_system import CrankshaftSystem
from dynamics.crankshaft.shaft_throw import RZ, UZ
from dynamics.crankshaft.stations import CLASSES
from dynamics.running_limits import within

# A mode of the shaft is looked for within this factor of the chain's frequency.
SEARCHED = 2.0
# A second mode shares the chain's mode where share times likeness is at least this.
DIVIDED = 0.25


@summarized(
    "kind", "chain_frequency [Hz]", "shaft_frequency [Hz]", "difference", "share", "likeness"
)
@dataclass(frozen=True)
class ModeMatch:
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

    kind: Kind
    chain_mode: int
    chain_frequency: float
    shaft_mode: int | None
    shaft_frequency: float | None
    share: float
    likeness: float
    chain_rigid: int = 0
    shaft_rigid: int = 0
    further_frequency: float | None = None
    further_share: float = 0.0

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
    crankshaft : CrankshaftSystem
    chain : EngineChain
        Axial or torsional, of the same throws.
    highest_frequency : float
        Highest frequency of the chain's modes considered [Hz].

    Returns
    -------
    tuple of ModeMatch
        As `match_modes`.

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
    """Find for some modes of a chain the most similar modes of the whole shaft.

    Parameters
    ----------
    shaft, modes, chain, wanted
        As for `mode_likeness`.

    Returns
    -------
    tuple of ModeMatch
        With the largest products of share and likeness in all; no mode of the shaft stands for two.

    Raises
    ------
    InputError
        If the chain has another number of throws.
    """
    share = modes.shares[CLASSES.index(chain.kind)]
    likeness = mode_likeness(shaft, modes, chain, wanted)
    scores = share * likeness
    chain_modes = chain.chain.modes()
    rigid, found = (chain_modes.rigid, modes.rigid), []
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
        found.append(ModeMatch(chain.kind, number, frequency, *match, *rigid, *further))
    return tuple(found)


def mode_likeness(
    shaft: AssembledShaft, modes: ShaftModes, chain: EngineChain, wanted: Sequence[int]
) -> FloatArray:
    """Return how much each mode of the whole shaft moves the chain's nodes as the chain's modes do.

    Parameters
    ----------
    shaft : AssembledShaft
    modes : ShaftModes
        Of that shaft.
    chain : EngineChain
    wanted : sequence of w int
        Modes of the chain, rigid ones counted.

    Returns
    -------
    ndarray of shape (w, q)
        Squared cosine between both shapes, weighted by the chain's masses; 0 beyond twice the frequency
        of the chain's mode and below half of it.

    Raises
    ------
    InputError
        As `match_modes`.
    """
    if chain.throws != shaft.section_count - 1:
        raise InputError(
            f"chain: given one of {chain.throws} throws; allowed is one of {shaft.section_count - 1}, "
            "because the shaft has so many."
        )
    nodes, moved = _moved_nodes(shaft, modes, chain)
    weight = chain.chain.mass_matrix()[np.ix_(nodes, nodes)]
    sizes = np.sum(moved * (weight @ moved), axis=0)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    chain_modes = chain.chain.modes()
    found = np.zeros((len(wanted), modes.frequencies.size))
    for row, number in enumerate(wanted):
        frequency, shape = (
            chain_modes.frequencies[number],
            weight @ chain_modes.shapes[nodes, number],
        )
        near = within(modes.frequencies, frequency / SEARCHED, frequency * SEARCHED)
        cosines = (shape @ moved) ** 2 / sizes / (shape @ chain_modes.shapes[nodes, number])
        found[row] = np.where(near, cosines, 0.0)
    return found


def followed_modes(masses: FloatArray, shapes: Sequence[FloatArray]) -> NDArray[np.int64]:
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
    rows = [np.arange(shapes[0].shape[1])]
    for before, after in pairwise(shapes):
        alike = (before.T @ masses @ after) ** 2
        rows.append(linear_sum_assignment(alike, maximize=True)[1][rows[-1]])
    return np.array(rows)


def _moved_nodes(
    shaft: AssembledShaft, modes: ShaftModes, chain: EngineChain
) -> tuple[list[int], FloatArray]:
    """Return the chain's nodes that the shaft has too, and how each mode moves them, (nodes, q).

    Along the shaft, or about it: throws, ends, damper ring, driven machine and shaft line. Without
    these a mode of the ring resembles one of the crankshaft, whose throws it moves alike.
    """
    motions = modes.motions
    sections = shaft.section_count
    added = dict(
        zip(
            shaft.names[len(shaft.names) - len(shaft.added) :],
            shaft.added @ modes.shapes,
            strict=True,
        )
    )
    if chain.kind == "axial":
        moved, ends = dict(zip(chain.sections, motions[:sections, UZ], strict=True)), {}
    else:
        pins = np.array(shaft.pin_throws)
        turns = motions[sections : sections + len(pins), RZ]
        throws = (turns[pins == throw].mean(axis=0) for throw in np.unique(pins))
        moved = dict(zip(chain.throw_nodes, throws, strict=True))
        ends = {FREE_END: motions[0, RZ], FLYWHEEL: motions[sections - 1, RZ]} | added
    for node, name in enumerate(chain.nodes):
        beside = ends.get(name, added.get(f"{name} {MOTION_OF[chain.kind]}"))
        if node not in moved and beside is not None:
            moved[node] = beside
    return list(moved), np.array(list(moved.values()))
