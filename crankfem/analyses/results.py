"""The numbers of a run as plain JSON content: what the report shows and ``--json`` prints."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from crankfem.analyses.checks import asymmetry
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.modes import SourceResult, Vibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.reading.toml_file import InputRecord
from dynamics.chains.two_mass import TwoMassCheck
from dynamics.harmonics import Harmonics
from fem.modes import ThrowModes
from fem.reciprocity import superelement_of_end_forces
from fem.shaft import ShaftCompliances
from fem.supports import Support, reactions
from fem.throw_analysis import ThrowAnalysis
from geometry.balance import unbalance
from geometry.crankshaft import Crankshaft
from geometry.mesher import Throw
from geometry.throw import CrankThrow

SUPPORTS: tuple[Support, ...] = ("pinned", "guided")


def input_records(records: Iterable[InputRecord]) -> list[Record]:
    """Every input with its source."""
    return [
        {
            "field": record.field,
            "given": record.given,
            "meaning": record.meaning,
            "symbol": record.symbol,
            "source": record.source,
            "assumed": record.assumed,
        }
        for record in records
    ]


def throw_record(analysis: ThrowAnalysis, radial_force: float) -> Record:
    """Compliances, reactions and masses of a throw.

    Parameters
    ----------
    analysis : ThrowAnalysis
    radial_force : float
        Z for which reactions are given [N].
    """
    supports = {}
    for support in SUPPORTS:
        answer = analysis.supported(support)
        found = analysis.reactions((0.0, -radial_force, 0.0), support)
        supports[str(support)] = {
            "axial_compliance": answer.axial,
            "torsional_compliance": answer.torsional,
            "influence_coefficient": answer.influence,
            "axial_force_per_radial": answer.influence / answer.axial,
            "reactions": {
                side: {"force": reaction.force.tolist(), "moment": reaction.moment.tolist()}
                for side, reaction in (("left", found.left), ("right", found.right))
            },
        }
    return {
        "dimensions": _dimensions(analysis.throw),
        "material": analysis.material.model_dump(),
        "supports": supports,
        "radial_force": radial_force,
        "mass": analysis.mass,
        "center_of_mass": analysis.center_of_mass.tolist(),
        "inertia": analysis.inertia.tolist(),
        "inertia_about_shaft": analysis.masses.inertia_about_shaft,
        "unbalance": _unbalance(analysis),
        "stiffness": analysis.stiffness.tolist(),
        "error_estimate": analysis.error_estimate,
        "accuracy": analysis.accuracy,
        "accuracy_met": analysis.accuracy_met,
        "unknowns": analysis.mesh.unknowns,
        "model": f"{analysis.mesh.part}, second-order tetrahedra, end sections {analysis.end_sections}",
        "remarks": list(analysis.throw.remarks),
        "meshing_attempts": list(analysis.mesh.attempts),
        "mended_elements": analysis.mesh.mended_elements,
        "solver": analysis.solver,
        "seconds": dict(analysis.seconds),
    }


def reciprocity_record(analysis: ThrowAnalysis) -> Record:
    """How well reciprocity holds between separate solutions of a throw, as shares.

    Returns
    -------
    dict
        "asymmetry": largest difference between the stiffness made of end forces and its transpose,
        beside the largest stiffness, with rotations measured as length x angle; "axial_reaction": the
        largest difference, of the supports, between c Z / e_n and the axial reaction by the end forces
        under a radial force Z on the first pin, beside Z.
    """
    elements = analysis.superelement
    by_forces = superelement_of_end_forces(analysis.classes, elements.radials)
    radial = elements.radials[0]
    differences = []
    for support in SUPPORTS:
        answer = analysis.supported(support)
        ends = reactions(elements, support, by_forces.end_load(radial))
        differences.append(abs(ends.left.force[2] - answer.influence / answer.axial))
    return {
        "asymmetry": asymmetry(by_forces.stiffness, analysis.mesh.length),
        "axial_reaction": float(max(differences)),
    }


def mode_records(modes: ThrowModes) -> list[Record]:
    """Natural modes of the free throw [Hz], with what moves."""
    return [
        {"frequency": float(frequency), "name": name}
        for frequency, name in zip(modes.frequencies, modes.names, strict=True)
    ]


def _dimensions(throw: Throw) -> Record:
    """What was given: fields in SI units, or the file of a CAD part with what was found in it."""
    if isinstance(throw, CrankThrow):
        return throw.model_dump(mode="json")
    return {
        "file": throw.path,
        "sha256": throw.digest,
        "length": throw.length,
        "pins": [
            {"name": pin.name, "axis": list(pin.axis), "diameter": 2.0 * pin.radius}
            for pin in throw.pins
        ],
        "main_journal_diameters": [2.0 * radius for radius in throw.journal_radii],
        "remarks": list(throw.remarks),
    }


def _unbalance(analysis: ThrowAnalysis) -> Record:
    """Static unbalance [kg m] and, about the throw's middle, the dynamic one [kg m^2]."""
    found = unbalance(analysis.masses, analysis.throw.length / 2.0)
    return {"static": found.static.tolist(), "dynamic": found.dynamic.tolist()}


def shaft_record(shaft: ShaftCompliances, analysis: ThrowAnalysis) -> Record:
    """Compliances of each throw at its place in the shaft."""
    return {
        "axial": shaft.axial.tolist(),
        "axial_beside_pinned": (shaft.axial / analysis.axial_compliance("pinned")).tolist(),
        "torsional": shaft.torsional.tolist(),
        "torsional_beside_pinned": (
            shaft.torsional / analysis.torsional_compliance("pinned")
        ).tolist(),
        "influence": shaft.influence.tolist(),
    }


def balance_record(engine_file: EngineFile) -> Record:
    """Masses and unbalance of the whole crankshaft, about the middle of its throws; no rods."""
    throws = [engine_file.throw] * len(engine_file.throw_angles)
    shaft = Crankshaft(throws, engine_file.throw_angles, engine_file.shaft_ends)
    masses = shaft.masses(engine_file.material.density)
    middle = 0.5 * float(shaft.starts[-1])
    found = unbalance(masses, middle)
    # What would be there if all throws pointed one way: beside it, round-off is nothing.
    one = engine_file.throw.crank_radius * masses.mass
    return {
        "mass": masses.mass,
        "length": shaft.length,
        "inertia_about_shaft": masses.inertia_about_shaft,
        "static": _without_round_off(found.static, one),
        "dynamic": _without_round_off(found.dynamic, one * shaft.length),
    }


def _without_round_off(values: NDArray[np.float64], scale: float) -> list[float]:
    return [0.0 if abs(value) < 1e-9 * scale else float(value) for value in values]


def vibration_record(vibration: Vibration) -> Record:
    """Modes and critical speeds with the chosen compliances, first frequencies with all."""
    chosen = vibration.chosen
    return {
        "kind": vibration.kind,
        "source": chosen.source,
        "nodes": list(chosen.chain.nodes),
        "inertia": chosen.chain.chain.inertia.tolist(),
        "stiffness": chosen.chain.chain.stiffness.tolist(),
        "ground": chosen.chain.chain.ground.tolist(),
        "modes": _mode_records(chosen),
        "criticals": [
            {
                "speed_rpm": found.critical.speed_rpm,
                "order": found.critical.order,
                "frequency": found.critical.frequency,
                "mode": found.critical.mode + 1,
                "phase_sum": found.phase_sum,
                "in_running_range": found.in_running_range,
            }
            for found in vibration.criticals
        ],
        "sources": [
            {
                "source": result.source,
                "first_frequencies": result.elastic_frequencies[:3].tolist(),
                "beside_chosen": float(
                    result.elastic_frequencies[0] / chosen.elastic_frequencies[0]
                ),
                "mean_compliance": float(result.compliances.mean()),
                "remark": result.remark,
            }
            for result in vibration.others
        ],
        "unusable": list(vibration.unusable),
    }


def _mode_records(result: SourceResult) -> list[Record]:
    modes = result.modes
    return [
        {
            "number": mode + 1 - modes.rigid,
            "frequency": float(modes.frequencies[mode]),
            "rigid": mode < modes.rigid,
            "node_positions": list(modes.node_positions[mode]),
            "shape": modes.shapes[:, mode].tolist(),
        }
        for mode in range(len(modes.frequencies))
    ]


def harmonics_record(found: Harmonics) -> Record:
    """Mean and harmonics M_k sin(k w t + a_k)."""
    return {
        "strokes": found.strokes,
        "samples": found.samples,
        "mean": found.mean,
        "highest_order": found.highest_order,
        "orders": found.orders.tolist(),
        "cosine": found.cosine.tolist(),
        "sine": found.sine.tolist(),
        "amplitude": found.amplitude.tolist(),
        "phase_deg": np.rad2deg(found.phase).tolist(),
    }


def two_mass_record(check: TwoMassCheck) -> Record:
    """The two-mass check."""
    return {
        "stiffness": check.stiffness,
        "angular_frequency": check.angular_frequency,
        "frequency": check.angular_frequency / (2.0 * math.pi),
        "vibrations_per_minute": check.vibrations_per_minute,
        "order": check.order,
        "resonant_speed_rpm": check.resonant_speed_rpm,
        "statement": check.statement,
    }
