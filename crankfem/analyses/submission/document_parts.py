"""The parts of a document, with sentences, tables and diagrams."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from crankbase.tables.table import Table


@dataclass(frozen=True)
class DocumentTable:
    """A table, and the name of its file."""

    name: str
    table: Table


@dataclass(frozen=True)
class DocumentPicture:
    """A diagram: its file name, its caption, its drawing function, whether two fit in a row."""

    name: str
    caption: str
    draw: Callable[[Path], None]
    half: bool = False


@dataclass(frozen=True)
class DocumentPart:
    """A part of the document: title, sentences, then tables and diagrams in their order.

    The name is used in addresses.
    """

    name: str
    title: str
    sentences: tuple[str, ...]
    items: tuple[DocumentTable | DocumentPicture, ...] = ()

    @property
    def tables(self) -> tuple[DocumentTable, ...]:
        """Its tables."""
        return tuple(one for one in self.items if isinstance(one, DocumentTable))

    @property
    def pictures(self) -> tuple[DocumentPicture, ...]:
        """Its diagrams."""
        return tuple(one for one in self.items if isinstance(one, DocumentPicture))
