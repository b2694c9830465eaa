"""Shaft lines joined to the last section of a crankshaft: chains whose first node is that section."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import Kind

# Of a node's motion about or along the shaft, behind its name, as those of the sections.
MOTION_OF = {"torsional": "rz", "axial": "uz"}


@dataclass(frozen=True, eq=False)
class JoinedLine:
    """A chain behind the crankshaft, in the unknowns of the whole shaft.

    Attributes
    ----------
    kind : {"torsional", "axial"}
    chain : Chain
        Its first node turns, or moves along the shaft, with the section.
    motions : (n, u) array
        Motions of its nodes per unknown, gears included.
    unknowns : (q - 1,) array of int
        Its own unknowns: of each group of nodes that gears couple, except that of the section, the
        motion of the first node.
    """

    kind: Kind
    chain: Chain
    motions: FloatArray
    unknowns: NDArray[np.int64]

    @property
    def names(self) -> tuple[str, ...]:
        """Of its nodes behind the section, such as "propeller rz"."""
        return tuple(f"{name} {MOTION_OF[self.kind]}" for name in self.chain.names[1:])

    def rigid_motions(self) -> tuple[FloatArray | None, list[tuple[FloatArray, str]]]:
        """Return the motions that no spring of the line resists.

        Returns
        -------
        with_section : (u,) array or None
            Of its own unknowns where the section moves by one; None where springs to ground hold it.
        alone : list of pairs of (u,) array and str
            Of parts that only dashpots join, with the names of their nodes.
        """
        leading = np.argmax(self.chain.expansion() != 0.0, axis=0)[1:]
        with_section, alone = None, []
        for motion in self.chain.rigid_motions()[0].T:
            column = np.zeros(self.motions.shape[1])
            column[self.unknowns] = motion[leading]
            if motion[0]:
                with_section = column / motion[0]
            else:
                nodes = np.flatnonzero(motion).tolist()
                alone.append((column, ", ".join(self.chain.names[node] for node in nodes)))
        return with_section, alone


def join_lines(
    lines: Sequence[tuple[Kind, Chain, int]], first: int, size: int
) -> tuple[JoinedLine, ...]:
    """Give the nodes of lines their motions in the unknowns of a whole shaft.

    Parameters
    ----------
    lines : sequence of kind, Chain and int
        With the unknown of the section that the first node moves with.
    first, size : int
        First of the unknowns left for lines, and the number of all.
    """
    found = []
    for kind, chain, section in lines:
        expand = chain.expansion()
        unknowns = np.arange(first, first + expand.shape[1] - 1)
        first += unknowns.size
        motions = np.zeros((len(expand), size))
        # Gears' groups are counted by their first nodes: the first one is the section's.
        motions[:, [section, *unknowns]] = expand
        found.append(JoinedLine(kind, chain, motions, unknowns))
    return tuple(found)
