"""Requirements of an engine for the torsional vibration document."""

from crankbase.errors import InputError
from crankfem.analyses.submission.firing_cases import damper_places
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.limits_sections import LimitsInput


def check_submission(engine: EngineFile) -> None:
    """Refuse an engine without the data for the document, and permitted values for parts that it lacks.

    Raises
    ------
    InputError
    """
    if engine.gas is None and engine.gas_map is None:
        raise InputError(
            f"{engine.path.name}: has no gas pressure; allowed is a file with a section [gas] or [gas_map], "
            "because the document reports stresses."
        )
    limits = engine.limits or LimitsInput()
    if limits.generator_angle is not None and engine.engine.generator_poles is None:
        raise InputError(
            "limits.generator_angle: given without engine.generator_poles; allowed are both, because the "
            "poles make electrical degrees of mechanical ones."
        )


def check_damper_limits(run: EngineVibration) -> None:
    """Refuse permitted values of a torsional damper that the chain does not have.

    Raises
    ------
    InputError
    """
    limits = run.engine_file.limits or LimitsInput()
    for name in ("damper_torque", "damper_heat"):
        if getattr(limits, name) is not None and not damper_places(run.torsional_chain):
            raise InputError(
                f"limits.{name}: given for an engine without a torsional damper; allowed is a chain with a "
                'node "damper ring", because the value is that of the damper.'
            )
