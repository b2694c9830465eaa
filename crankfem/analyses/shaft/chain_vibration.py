"""Natural vibration of the chain that a file describes."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.quantity import percent
from crankbase.results import Hertz, Internal, Part, Quantity, Result, result
from crankbase.table import Column, Table
from crankfem.analyses.shaft.chains import MOTION
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.reading.toml_file import TomlFile
from dynamics.chains.chain import Chain

# Modes and shares that tables show; the result holds all.
MODES_SHOWN, LEAST_SHARE = 10, 0.01


@result("name", "frequency", "modal_inertia")
class ChainFileMode(Result):
    """A natural mode, with the shares of its kinetic energy by node and of strain energy by spring."""

    name: str
    frequency: Hertz
    rigid: bool
    node_positions: Annotated[tuple[float, ...], Quantity("1", "in elements from the first node")]
    modal_inertia: Annotated[float, Quantity(".inertia_unit")]
    shape: Annotated[tuple[float, ...], Quantity("1")]
    kinetic_shares: Annotated[Mapping[str, float], Quantity("1")]
    strain_shares: Annotated[Mapping[str, float], Quantity("1")]


@result("name", "kind", "modes")
class ChainVibration(Result):
    """Nodes, elements, modes and energy shares of a chain."""

    name: str
    kind: str
    chain: Internal[Chain]
    sources: Mapping[str, str]

    @cached_property
    def nodes(self) -> Part[tuple[str, ...]]:
        """Their names."""
        return self.chain.names

    @cached_property
    def elements(self) -> Part[tuple[str, ...]]:
        """Their names."""
        return self.chain.elements

    @cached_property
    def inertia(self) -> Annotated[Array, Quantity(".inertia_unit")]:
        """Of the nodes."""
        return self.chain.inertia

    @cached_property
    def stiffness(self) -> Annotated[Array, Quantity(".stiffness_unit")]:
        """Of the elements."""
        return self.chain.stiffness

    @cached_property
    def ground(self) -> Annotated[Array, Quantity(".stiffness_unit")]:
        """Stiffness of the nodes to ground."""
        return self.chain.ground

    @cached_property
    def modes(self) -> Part[tuple[ChainFileMode, ...]]:
        """All modes, those of the rigid body first."""
        chain, modes = self.chain, self.chain.modes()
        return tuple(
            ChainFileMode(
                name=modes.names[mode],
                frequency=frequency,
                rigid=mode < modes.rigid,
                node_positions=tuple(modes.node_positions[mode]),
                modal_inertia=float(modes.modal_inertia[mode]),
                shape=tuple(modes.shapes[:, mode].tolist()),
                kinetic_shares=dict(
                    zip(chain.names, modes.kinetic_shares[:, mode].tolist(), strict=True)
                ),
                strain_shares=dict(
                    zip(modes.strain_names, modes.strain_shares[:, mode].tolist(), strict=True)
                ),
            )
            for mode, frequency in enumerate(modes.frequencies.tolist())
        )

    @property
    def inertia_unit(self) -> str:
        """Of the nodes."""
        return MOTION[self.kind].inertia

    @property
    def stiffness_unit(self) -> str:
        """Of the elements."""
        return MOTION[self.kind].stiffness

    def parts(self) -> Iterator[Table | str]:
        """Return the modes with their largest energy shares, and the sources of the chain's values."""
        yield from (f"[{name}] {text}" for name, text in self.sources.items())
        yield Table.of_records(
            f"{self.name}: {self.kind} modes",
            self.modes[:MODES_SHOWN],
            (Column("mode", words=True), "name"),
            (Column("frequency", "Hz", decimals=3), "frequency"),
            (Column("[1/min]", decimals=1), lambda mode: 60.0 * mode.frequency),
            (
                Column("nodes at", decimals=2, words=True),
                lambda mode: [1.0 + place for place in mode.node_positions],
            ),
            (Column("moves most", words=True), lambda mode: _largest(mode.kinetic_shares)),
            (Column("strained most", words=True), lambda mode: _largest(mode.strain_shares)),
            note="Nodes at 2.37 are at 37 % of element 2, counted from 1; shares are those of kinetic and of "
            "strain energy.",
            main=True,
        )


def chain_vibration(source: str | Path | TomlFile) -> ChainVibration:
    """Find the natural vibration of the chain in a chain file, or of a shipped chain by its name.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    read = load_chain(source)
    return ChainVibration(read.name, read.kind, read.chain, read.sources)


def _largest(shares: Mapping[str, float]) -> str:
    name = max(shares, key=lambda place: shares[place])
    share = shares[name]
    return f"{name} {percent(share, 3)} %" if share > LEAST_SHARE and np.isfinite(share) else ""
