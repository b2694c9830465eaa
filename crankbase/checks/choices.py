"""Words and names that are allowed, and what a wrong one may have been meant for."""

from collections.abc import Iterable

from crankbase.errors import InputError, quoted


def check_choice(option: str, given: object, allowed: Iterable[str], because: str) -> None:
    """Refuse what is none of the words allowed.

    Raises
    ------
    InputError
        If it is no word, or none of these.
    """
    words = list(allowed)
    if not isinstance(given, str) or given not in words:
        raise InputError(
            f"{option}: given {quoted(given)}; allowed are {', '.join(words)}, because {because}."
        )


def check_not_given(option: str, given: object, shown: str, because: str) -> None:
    """Refuse an option that what is shown has no use for.

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
