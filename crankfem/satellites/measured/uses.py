"""What the commands on measured vibration use of an engine file."""

from crankfem.files.engine.used_values import USES, Use
from crankfem.files.reading.toml_file import TomlFile


def used_sections(_content: TomlFile, _case: str = "") -> Use:
    """Return the sections and fields of the vibration without its verdict, and those not used."""
    used, without = USES["vibration"]
    return used, (*without, "limits", "ranges", "misfire", "strength.tensile_strength")
