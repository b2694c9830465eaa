"""What is refused before the throws of an engine are analyzed, for any compliance of theirs."""

import numpy as np

from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import (
    damped_engine_chain,
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.analyses.shaft.law_source import refuse_law
from crankfem.analyses.shaft.sources import axial_by_formulas, torsional_by_formulas
from crankfem.analyses.vibration.engine_excitation import with_propeller
from crankfem.analyses.vibration.engine_limits import ANY_COMPLIANCE, ANY_INERTIA, refuse_limits
from crankfem.files.engine.engine_file import EngineFile
from dynamics.response.order_excitation import OrderExcitation


def refuse_vibration(engine_file: EngineFile) -> None:
    """Refuse limits, sources of compliances and parts of chains with which no vibration is calculated.

    Raises
    ------
    InputError
    """
    refuse_limits(engine_file)
    refuse_law(engine_file)
    _refuse_formulas(engine_file)
    _refuse_chains(engine_file)


def _refuse_formulas(engine_file: EngineFile) -> None:
    """Refuse a published formula as the source where it gives a throw no compliance above zero."""
    throws, material = engine_file.crank_throws, engine_file.material
    vibration = engine_file.vibration
    for kind, given, sources in (
        (
            "axial",
            vibration.axial_source,
            axial_by_formulas(throws, engine_file.throw_angles_deg, material),
        ),
        ("torsional", vibration.torsional_source, torsional_by_formulas(throws, material)),
    ):
        for name, (values, _) in sources.items():
            if name.casefold() == given.casefold() and not np.all(values > 0.0):
                raise InputError(
                    f"vibration.{kind}_source: given {given!r}, which gives a throw a compliance of "
                    f"{np.min(values):.3g}; give another source, such as 'fe', because a compliance is above "
                    "zero."
                )


def _refuse_chains(engine_file: EngineFile) -> None:
    """Refuse what does not fit the chains, whatever their throws' compliances are."""
    count = len(engine_file.throw_angles_deg)
    compliances, some = np.full(count, ANY_COMPLIANCE), np.full(count, ANY_INERTIA)
    inertias = engine_throw_inertias(engine_file, ANY_INERTIA)
    for chain in (
        engine_axial_chain(engine_file, compliances, some),
        engine_torsional_chain(engine_file, compliances, inertias),
    ):
        _ = damped_engine_chain(engine_file, chain)
        still = np.zeros((1, 1, len(chain.nodes)), dtype=np.complex128)
        speed = np.array([engine_file.engine.rated_speed])
        excitation = OrderExcitation(np.ones(1), speed, still)
        _ = with_propeller(engine_file, chain, excitation)
