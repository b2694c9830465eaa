"""What the class document uses of an engine file, as `crankfem.files.engine.used_values` tells it."""

from crankfem.files.engine.used_values import ALL, AXIAL_ALONE, DRIVES, RUN_ALONE, SKIRT, WHOLE, Use
from crankfem.files.reading.toml_file import TomlFile

AXIAL_LIMITS = {"axial_amplitude", "axial_force"}
# What the document, which is on torsion, takes only to judge a limit of the axial vibration.
TO_JUDGE_AXIAL = (
    *(*AXIAL_ALONE, "damping.axial_magnifier", "vibration.axial_source", "shaft_line.axial"),
    *("ranges.axial_compliance", "ranges.mass", "ranges.thrust_stiffness"),
    *("propeller_forces.rated_thrust", "propeller_forces.thrust_shares"),
    "propeller_forces.thrust_phases",
)


def used_sections(content: TomlFile, _: str) -> Use:
    """Return the sections and fields that it uses, and those that it does not."""
    without: tuple[str, ...] = (*RUN_ALONE, *WHOLE, SKIRT)
    if not AXIAL_LIMITS & content.sections.get("limits", {}).keys():
        without += TO_JUDGE_AXIAL
    return (ALL, "strength.tensile_strength", DRIVES), without
