"""Where the shipped engines and tables lie, in the wheel and in a checkout."""

from pathlib import Path

from crankbase.errors import InputError


def data_folder() -> Path:
    """Return the folder of shipped data."""
    here = Path(__file__).resolve().parents[2]
    inside = here / "data"
    return inside if inside.is_dir() else here.parent / "data"


def shipped_engines() -> tuple[str, ...]:
    """Return the names of the shipped engine files."""
    return _shipped("engines")


def shipped_hinges() -> tuple[str, ...]:
    """Return the names of the shipped hinge files."""
    return _shipped("hinges")


def shipped_chains() -> tuple[str, ...]:
    """Return the names of the shipped chain files."""
    return _shipped("chains")


def engine_path(given: str | Path) -> Path:
    """Find an engine file by path, or a shipped one by name.

    Raises
    ------
    InputError
        If there is neither.
    """
    return _found(given, "engines", "an engine file")


def hinge_path(given: str | Path) -> Path:
    """Find a hinge file by path, or a shipped one by name.

    Raises
    ------
    InputError
        If there is neither.
    """
    return _found(given, "hinges", "a hinge file")


def chain_path(given: str | Path) -> Path:
    """Find a chain file by path, or a shipped one by name.

    Raises
    ------
    InputError
        If there is neither.
    """
    return _found(given, "chains", "a chain file")


def torque_path(given: str | Path) -> Path:
    """Find a torque table by path, or a shipped one by the name of its file.

    Raises
    ------
    InputError
        If there is neither.
    """
    path = Path(given)
    shipped = data_folder() / "tables" / path.name
    if path.is_file() or path.parent != Path() or path.name not in shipped_torques():
        return path
    return shipped


def shipped_torques() -> tuple[str, ...]:
    """Return the names of the shipped torque tables."""
    return tuple(sorted(path.name for path in (data_folder() / "tables").glob("*torque*.csv")))


def _shipped(folder: str) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in (data_folder() / folder).glob("*.toml")))


def _found(given: str | Path, folder: str, what: str) -> Path:
    path = Path(given)
    if not str(given).strip():
        raise InputError(
            f'"": names no file; give the path of {what}, or the name of a shipped one '
            f"({', '.join(_shipped(folder))})."
        )
    if path.is_file():
        return path
    shipped = data_folder() / folder / f"{path.name.removesuffix('.toml')}.toml"
    if path.parent == Path() and shipped.is_file():
        return shipped
    kind = "is a folder, not a file" if path.is_dir() else "does not exist"
    raise InputError(
        f"{given}: {kind}; give the path of {what}, or the name of a shipped one "
        f"({', '.join(_shipped(folder))})."
    )


def find_table(field: str, beside: Path, name: str) -> Path:
    """Find a table beside a file that names it, or a shipped one.

    Parameters
    ----------
    field : str
        The field that names it, for the message.
    beside : Path
        The file that names it.
    name : str
        Of the table's file.

    Raises
    ------
    InputError
        If there is neither.
    """
    for path in (beside.parent / name, data_folder() / "tables" / name):
        if path.is_file():
            return path
    raise InputError(
        f"{field}: given {name!r}, which is neither beside the engine file nor a shipped table."
    )
