"""What a calibration uses of an engine file, as `crankfem.files.engine.used_values` tells it."""

from crankfem.files.engine.used_values import USES, Use
from crankfem.files.reading.toml_file import TomlFile


def used_sections(_: TomlFile, _case: str = "") -> Use:
    """Return the sections and fields that it uses, and those that it does not: those of the verdict."""
    return USES["vibration"]
