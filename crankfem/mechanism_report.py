"""What the report says of the crank mechanism: loads, torque and balance at rated speed."""

from pathlib import Path
from typing import Any

from crankfem.balance_tables import balance_record
from crankfem.mechanism_file import MechanismFile
from crankfem.mechanism_run import run_mechanism
from crankfem.mechanism_tables import mechanism_record
from crankfem.pictures.mechanism_pictures import picture_mechanism
from geometry.mass import MassProperties


def mechanism_results(
    mechanism: MechanismFile, masses: MassProperties, pictures: Path
) -> tuple[dict[str, Any], dict[str, str]]:
    """Calculate the mechanism at rated speed and draw its diagrams.

    Parameters
    ----------
    mechanism : MechanismFile
        With gas pressure.
    masses : MassProperties
        Of one throw.
    pictures : Path
        Folder for the diagrams.

    Returns
    -------
    dict
        The record, with the balance.
    dict
        Picture name to file name.
    """
    run = run_mechanism(mechanism, masses=masses)
    record = mechanism_record(run) | {"balance": balance_record(run.balance)}
    drawn = {path.stem: path.name for path in picture_mechanism(pictures, run)}
    return record, drawn
