"""Which throw of a file a command takes."""

from crankfem.cli import console
from crankfem.files.engine.throw_file import load_throw, names_of_throws
from crankfem.files.reading.toml_file import TomlFile
from fem.material import Material
from geometry.throw import CrankThrow


def select_throw(
    engine: str | TomlFile, name: str | None = None, quiet: bool = False
) -> tuple[CrankThrow, Material]:
    """Select the throw of a name; without one that at the free end, and say so where there are others.

    Parameters
    ----------
    engine : str or TomlFile
        File, or the name of a shipped engine; or its sections, read already.
    name : str, optional
        As `--throw` gives it.
    quiet : bool
        Whether to say nothing.

    Raises
    ------
    InputError
    """
    if name is None:
        first, *others = names_of_throws(engine)
        if others:
            console.print_note(
                f"Note: throw {first} is taken; the file has {', '.join(others)} too.", quiet
            )
    return load_throw(engine, name)
