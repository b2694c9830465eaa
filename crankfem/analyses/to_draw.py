"""Pictures that are still to be drawn: which files, and what draws each."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from crankbase.outputs import check_output


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
    """Draw pictures one after another and return their files; the first that fails ends it.

    None is drawn if one of the files is somebody else's.
    """
    pictures, made = list(pictures), []
    for picture in pictures:
        check_output(picture.path, "picture")
    for picture in pictures:
        picture.draw(picture.path)
        made.append(picture.path)
    return made
