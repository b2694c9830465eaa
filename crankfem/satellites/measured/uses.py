"""What commands on measured vibration use of an engine file, for `crankfem.files.engine.used_values`."""

from crankfem.files.engine.used_values import USES, Use
from crankfem.files.reading.toml_file import TomlFile


def used_by_measured(_content: TomlFile, _case: str = "") -> Use:
    """Return the sections and fields of the vibration without its verdict, and those not used."""
    used, without = USES["vibration"]
    return used, (*without, "limits", "ranges", "misfire", "strength.tensile_strength")


def used_by_calibrate(_content: TomlFile, _case: str = "") -> Use:
    """Return the sections and fields that it uses, and those that it does not: those of the verdict."""
    return USES["vibration"]
