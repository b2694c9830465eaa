"""Words that an option of a plot or a table may be."""

from collections.abc import Iterable

from geometry.errors import InputError


def check_choice(option: str, given: str, allowed: Iterable[str], because: str) -> None:
    """Refuse a word that is none of those allowed.

    Raises
    ------
    InputError
    """
    words = list(allowed)
    if given not in words:
        raise InputError(
            f"{option}: given {given!r}; allowed are {', '.join(words)}, because {because}."
        )
