"""Looked-up reactions as a record, and the table of them."""

from collections.abc import Callable, Sequence

from crankbase.errors import InputError
from crankbase.tables.table import OutputUnits
from crankfem.analyses.record import Record, attributes
from crankfem.analyses.throw.throw_record import reaction_table
from crankfem.cli.console import print_line, print_table
from fem.supports import Neighbors, Support
from regression.models.lookup import ReactionLookup


def reaction_record(
    react: Callable[..., ReactionLookup], force: Sequence[float], gamma: float | None
) -> Record:
    """Look reactions up under each possible support, as plain JSON content.

    Parameters
    ----------
    react : callable
        Force and support to reactions, as `ComplianceModel.reactions`.
    force : (3,) sequence of float
        On the pin [N].
    gamma : float or None
        Angle to equal neighbors, for one more support [deg].

    Raises
    ------
    InputError
        If there is none.
    """
    supports: dict[str, Support] = {"pinned": "pinned", "guided": "guided"}
    if gamma is not None:
        supports[f"neighbors {gamma:g} deg"] = Neighbors(gamma, gamma)
    found: Record = {}
    refused: dict[str, str] = {}
    for name, support in supports.items():
        try:
            answer = react(force, support)
        except InputError as error:
            refused[name] = str(error)
            continue
        found[name] = {
            kind: {
                side: attributes(getattr(ends, side), "force", "moment")
                for side in ("left", "right")
            }
            for kind, ends in (("reactions", answer), ("band", answer.band))
        } | {"inside": bool(answer.inside)}
    if not found:
        raise InputError(next(iter(refused.values())))
    return {"pin_force": force, "radial_force": -force[1], "supports": found, "refused": refused}


def print_reactions(record: Record, units: OutputUnits) -> None:
    """Print reactions as those of a throw by finite elements, with their bands."""
    print_table(reaction_table(record, units), units)
    kilonewtons = units.of("kN")
    for name, own in record["supports"].items():
        push, band = (own[kind]["left"]["force"][2] for kind in ("reactions", "band"))
        if not own["inside"]:
            told = "OUTSIDE the range, where no band applies"
        elif band is None:
            told = "its band is open"
        else:
            told = f"within {kilonewtons.with_name(band, 3)} of {kilonewtons.with_name(push, 4)}"
        print_line(f"Axial reaction {name}: {told}")
    for name, reason in record["refused"].items():
        print_line(units.text(f"Reactions {name}: left out; {reason}"))
