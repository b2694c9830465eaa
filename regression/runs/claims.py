"""Claims on designs: of several programs that use one store, only one computes a design.

A claim is a lock on one byte of a file next to the store. The system releases it with the program that holds
it, however that ends. Without such locks, as on Windows, every claim is granted.
"""

import contextlib
import errno
import hashlib
import os
import sys
from pathlib import Path

if sys.platform != "win32":
    import fcntl

# The byte that everyone who has the file open shares, and the number of the other bytes.
IN_USE, BYTES = 0, 2**60


class Claims:
    """Claims of this program on the designs of a store, until they are released or the program ends.

    Parameters
    ----------
    store : Path
    """

    def __init__(self, store: Path) -> None:
        self._path = Path(f"{store}-claims")
        self._file: int | None = None
        with contextlib.suppress(OSError):  # the store's own errors say what is wrong with the disk
            self._file = self._opened()

    def __enter__(self) -> "Claims":
        return self

    def __exit__(self, *_: object) -> None:
        """Release all claims; the last program removes the file."""
        if self._file is None:
            return
        if self.alone():
            self._path.unlink(missing_ok=True)
        os.close(self._file)
        self._file = None

    def take(self, key: str) -> bool:
        """Claim a design; False if another program has it."""
        return self._locked(_place(key))

    def release(self, key: str) -> None:
        """Release a design."""
        if self._file is not None:
            fcntl.lockf(self._file, fcntl.LOCK_UN, 1, _place(key))

    def alone(self) -> bool:
        """Keep other programs away from the store; False if there is one."""
        return self._locked(IN_USE)

    def _locked(self, place: int) -> bool:
        if self._file is None:
            return True
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)
        except OSError as error:
            # A file system without locks grants every claim.
            return error.errno not in (errno.EACCES, errno.EAGAIN)
        return True

    def _opened(self) -> int | None:
        while sys.platform != "win32":
            file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            with contextlib.suppress(OSError):
                fcntl.lockf(file, fcntl.LOCK_SH, 1, IN_USE)
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(file), self._path.stat()):
                    return file
            os.close(file)  # another program has just removed it
        return None


def _place(key: str) -> int:
    return 1 + int.from_bytes(hashlib.sha256(key.encode()).digest()[:8]) % BYTES
