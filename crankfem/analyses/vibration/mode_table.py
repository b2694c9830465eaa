"""The table of a chain's natural modes, from its plain record."""

from crankbase.tables.table import Column, Table
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.tables import FREQUENCY
from dynamics.chains.engine_chains import FREE_END


def mode_table(record: Record) -> Table:
    """Return the natural modes of one kind, from its `vibration_record`."""
    names = record["nodes"]
    # Points have the numbers of their names: throws and main bearings count from 1.
    first = 0 if names[0].startswith(FREE_END) else 1
    return Table(
        f"{record['kind'].capitalize()} modes (compliances: {record['source']})",
        [
            Column("mode", words=True),
            FREQUENCY,
            Column("[1/min]", decimals=0),
            Column("nodes at", words=True),
        ],
        [
            [
                "rigid body" if one["rigid"] else f"{one['number']}{_beside_crankshaft(one)}",
                one["frequency"],
                60.0 * one["frequency"],
                "moves as one" if one["rigid"] else _still_at(one["node_positions"], record, first),
            ]
            for one in record["modes"]
        ],
        note=f"Node positions count the chain's points: {_points(names, first)}.",
    )


def _points(names: list[str], first: int) -> str:
    """Name all points by their numbers; those whose own numbers ascend along the chain together.

    Examples
    --------
    >>> _points(["free end", "throw 1", "throw 2", "throw 3", "flywheel"], 0)
    '0 free end, 1 to 3 throw 1 to throw 3, 4 flywheel'
    """
    runs: list[list[int]] = []
    for place, name in enumerate(names):
        before = names[place - 1].rpartition(" ") if place else ("", "", "")
        stem, _, number = name.rpartition(" ")
        follows = before[2].isdecimal() and number.isdecimal() and int(number) == int(before[2]) + 1
        if follows and stem == before[0]:
            runs[-1].append(place)
        else:
            runs.append([place])
    return ", ".join(
        f"{first + run[0]} {names[run[0]]}"
        if len(run) == 1
        else f"{first + run[0]} to {first + run[-1]} {names[run[0]]} to {names[run[-1]]}"
        for run in runs
    )


def _still_at(positions: list[float], record: Record, first: int) -> str | None:
    """State the positions of a mode's nodes: by the numbers of the points, or on their branch."""
    names = record["nodes"]
    # Results of older runs say nothing of branches.
    pairs = record.get("connections") or [(node, node + 1) for node in range(len(names) - 1)]
    found = []
    for position in positions:
        element = min(int(position), len(pairs) - 1)
        (left, right), share = pairs[element], position - element
        row = f"{first + left + share:.2f}"
        branch = f"{share:.2f} of the way from {names[left]} to {names[right]}"
        found.append(row if right == left + 1 else branch)
    return ", ".join(found) or None


def _beside_crankshaft(mode: Record) -> str:
    return "" if mode.get("of_crankshaft", True) else " (coupling, damper or line)"
