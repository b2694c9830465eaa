"""Pictures that are still to be drawn: which files, and what draws each."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ToDraw:
    """A picture that is still to be drawn.

    Attributes
    ----------
    path : Path
        Its file.
    draw : callable
        Draws it into that file.
    """

    path: Path
    draw: Callable[[Path], object]


def draw_all(pictures: Iterable[ToDraw]) -> list[Path]:
    """Draw pictures one after another and return their files; the first that fails ends it."""
    made = []
    for picture in pictures:
        picture.draw(picture.path)
        made.append(picture.path)
    return made
