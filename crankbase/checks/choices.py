"""Allowed words and names, and suggestions for wrong ones."""

from collections.abc import Iterable
from difflib import get_close_matches
from types import UnionType

from crankbase.errors import InputError, quoted


def check_choice(option: str, given: object, allowed: Iterable[str], because: str) -> None:
    """Refuse a word that is not allowed.

    Raises
    ------
    InputError
        If it is not a word, or not one of these.
    """
    words = list(allowed)
    if not isinstance(given, str) or given not in words:
        raise InputError(
            f"{option}: given {quoted(given)}; allowed are {', '.join(words)}, because {because}."
        )


def check_kind(field: str, given: object, kind: type | UnionType, allowed: str) -> None:
    """Refuse an object of another kind; `allowed` names what it must be.

    Raises
    ------
    InputError
    """
    if not isinstance(given, kind):
        raise InputError(f"{field}: given {quoted(given)}; allowed is {allowed}.")


def check_not_given(option: str, given: object, shown: str, because: str) -> None:
    """Refuse an option that does not apply to the chosen plot.

    Raises
    ------
    InputError
        If it is given, that is, neither None nor empty.
    """
    empty = given is None or (isinstance(given, tuple | list | dict | set) and not given)
    if not empty:
        raise InputError(
            f"{option}: given {quoted(given)} with {shown!r}; allowed is none, because {because}."
        )


def did_you_mean(given: str, names: Iterable[str], cutoff: float = 0.6, form: str = "{}") -> str:
    """Return "did you mean NAME? " of the closest name; nothing if none is close, or several share the word.

    Parameters
    ----------
    given : str
    names : iterable of str
    cutoff : float
        Required similarity, 0 to 1.
    form : str
        Format of a name, such as ``"[{}]"``.

    Examples
    --------
    >>> did_you_mean("lenght", ["length", "mass"])
    'did you mean length? '
    >>> did_you_mean("pressure", ["peak_pressure", "intake_pressure"])
    ''
    """
    known = list(names)
    if sum(given in name.split("_") for name in known) > 1:
        return ""
    close = get_close_matches(given, known, n=1, cutoff=cutoff)
    return f"did you mean {form.format(close[0])}? " if close else ""


def allowed_names(given: str, names: Iterable[str]) -> str:
    """Return the allowed names for an unknown one, the most similar first."""
    known = list(names)
    return f"{did_you_mean(given, known)}allowed are {', '.join(known)}"
