"""Files of input: on disk, or sent; each is read in one step, within a limit of its size."""

import os
from dataclasses import dataclass
from pathlib import Path

from crankbase.errors import InputError
from crankbase.text_limits import check_file_size, check_size
from crankbase.wrong_files import LOOKED_AT, wrong_kind


@dataclass(frozen=True)
class InputFile:
    """A file of input.

    Attributes
    ----------
    path : Path
        What messages call it, and where it is unless it was sent.
    sent : bytes, optional
        Its content, if it was sent: nothing is opened then.
    """

    path: Path
    sent: bytes | None = None

    @classmethod
    def of(cls, given: "GivenFile") -> "InputFile":
        """Return a file that is given by its path."""
        return given if isinstance(given, InputFile) else cls(Path(given))

    def content(self, most: int, what: str) -> bytes:
        """Read the file, of so many bytes at most; `what` is for the message.

        Raises
        ------
        InputError
            If it is larger, or cannot be read.
        """
        if self.sent is not None:
            check_size(self.path, len(self.sent), most, what)
            return self.sent
        check_file_size(self.path, most, what)
        try:
            return self.path.read_bytes()
        except OSError as error:
            why = error.strerror or error
            raise InputError(f"{self.path}: cannot be read as {what} ({why}).") from None

    def text(self, most: int, what: str, allowed: str, fits: str = "") -> str:
        r"""Read the file as text in UTF-8, its lines ended by ``\n``.

        Parameters
        ----------
        most : int
            Bytes.
        what, allowed : str
            Purpose of the file and the allowed content, for messages.
        fits : str
            What `wrong_kind` says of files of this kind.

        Raises
        ------
        InputError
            If it is larger, of another kind, no text, or cannot be read.
        """
        content = self.content(most, what)
        wrong = wrong_kind(content[:LOOKED_AT])
        if wrong is not None and wrong != fits:
            raise InputError(f"{self.path}: {wrong}; allowed is {allowed}.")
        try:
            return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise InputError(
                f"{self.path}: cannot be read as text, because line {line} is not UTF-8; allowed is "
                f"{allowed} in UTF-8."
            ) from None


GivenFile = str | os.PathLike[str] | InputFile
