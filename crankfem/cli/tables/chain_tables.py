"""Modes of a chain file as plain numbers and as tables."""

import numpy as np

from crankbase.tables.table import SI, Column, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.cli.console import number, print_line, print_table
from crankfem.files.chain.chain_file import ChainFile

# Modes and shares that tables show; records hold all.
MODES_SHOWN, LEAST_SHARE = 10, 0.01


def chain_record(read: ChainFile) -> Record:
    """Return nodes, elements, modes and energy shares, in SI units."""
    chain, modes = read.chain, read.chain.modes()
    return {
        "name": read.name,
        "kind": read.kind,
        "nodes": list(chain.names),
        "elements": list(chain.elements),
        "inertia": chain.inertia.tolist(),
        "stiffness": chain.stiffness.tolist(),
        "ground": chain.ground.tolist(),
        "modes": [
            {
                "name": modes.names[mode],
                "frequency": float(modes.frequencies[mode]),
                "rigid": mode < modes.rigid,
                "node_positions": list(modes.node_positions[mode]),
                "modal_inertia": float(modes.modal_inertia[mode]),
                "shape": modes.shapes[:, mode].tolist(),
                "kinetic_shares": dict(
                    zip(chain.names, modes.kinetic_shares[:, mode].tolist(), strict=True)
                ),
                "strain_shares": dict(
                    zip(modes.strain_names, modes.strain_shares[:, mode].tolist(), strict=True)
                ),
            }
            for mode in range(modes.frequencies.size)
        ],
        "sources": read.sources,
    }


def print_chain(record: Record, units: OutputUnits = SI) -> None:
    """Print the modes of a chain, with their largest energy shares."""
    print_table(
        Table.of_records(
            f"{record['name']}: {record['kind']} modes",
            record["modes"][:MODES_SHOWN],
            (Column("mode", words=True), "name"),
            (Column("frequency", "Hz", decimals=3), "frequency"),
            (Column("[1/min]", decimals=1), lambda mode: 60.0 * mode["frequency"]),
            (
                Column("nodes at", decimals=2, words=True),
                lambda mode: [1.0 + place for place in mode["node_positions"]],
            ),
            (Column("moves most", words=True), lambda mode: _largest(mode["kinetic_shares"])),
            (Column("strained most", words=True), lambda mode: _largest(mode["strain_shares"])),
            note="Nodes at 2.37 are at 37 % of element 2, counted from 1; shares are those of kinetic and of "
            "strain energy.",
        ),
        units,
    )
    for name, text in record["sources"].items():
        print_line(f"[{name}] {text}")


def _largest(shares: dict[str, float]) -> str:
    name = max(shares, key=lambda one: shares[one])
    share = shares[name]
    return (
        f"{name} {number(100.0 * share, 3)} %" if share > LEAST_SHARE and np.isfinite(share) else ""
    )
