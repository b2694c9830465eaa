"""Limits of the service: sizes, times, memory, and permitted clients."""

from dataclasses import dataclass
from pathlib import Path

from crankbase.calls import GIGABYTE
from crankbase.checks.choices import is_whole_within
from crankbase.errors import InputError

LOOPBACK = ("127.0.0.1", "localhost", "::1")
SHORTEST_KEY = 16
MEGABYTE = 1_000_000


@dataclass(frozen=True)
class Bounds:
    """Limits of the service.

    Attributes
    ----------
    body : int
        Of a request [byte]; a lookup of 100,000 throws takes about 6 MB.
    seconds : float
        For a request to arrive, its head and then its body [s].
    waiting : int
        Jobs that may wait.
    running : int
        Jobs that run at a time.
    workers : int
        Worker processes of each study.
    job_seconds : float
        For one job [s].
    job_memory : float
        For the process of one job and all that it starts [byte].
    check_seconds : float
        For reading and checking an uploaded file [s].
    rows : int
        Of one lookup.
    connections : int
        At a time.
    """

    body: int = 32 * MEGABYTE
    seconds: float = 10.0
    waiting: int = 20
    running: int = 1
    workers: int = 2
    job_seconds: float = 4 * 3600.0
    job_memory: float = 8.0 * GIGABYTE
    check_seconds: float = 30.0
    rows: int = 200_000
    connections: int = 500


@dataclass(frozen=True)
class Settings:
    """Where the service listens, who may ask, and where its jobs lie.

    Attributes
    ----------
    folder : Path
        Of jobs and their files.
    models : Path or None
        Folder of compliance models.
    host : str
    port : int
        Port; 0 for any free one.
    key : str or None
        That every request to the API must bring; always there where others than this machine can ask.
    bounds : Bounds

    Raises
    ------
    InputError
        If the port is none, the key is too short, or one is missing.
    """

    folder: Path
    models: Path | None = None
    host: str = "127.0.0.1"
    port: int = 8765
    key: str | None = None
    bounds: Bounds = Bounds()

    def __post_init__(self) -> None:
        if not is_whole_within(self.port, 0, 65535):
            raise InputError(
                f"--port: given {self.port!r}; allowed is 0 to 65535, 0 for any free one."
            )
        if self.key is not None and (len(self.key) < SHORTEST_KEY or not self.key.isascii()):
            raise InputError(
                f"key: given one of {len(self.key)} characters; allowed are {SHORTEST_KEY} or more, all "
                "ASCII, because shorter ones can be guessed."
            )
        if not self.host.strip():
            raise InputError(
                f"--host: given {self.host!r}; allowed is an address or a name of this machine, because "
                "an empty one would mean all of its addresses."
            )
        if not self.is_loopback and self.key is None:
            raise InputError(
                f"--host: given {self.host!r} without a key; allowed is {LOOPBACK[0]}, or --key-file beside "
                "--host, because whoever reaches this machine could use the service."
            )
        if self.models is not None and not self.models.is_dir():
            raise InputError(
                f"--models: given {self.models}, which is not a folder; allowed is one with "
                "compliance models."
            )

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can ask."""
        return self.host in LOOPBACK

    @property
    def who(self) -> str:
        """Who is answered, in words."""
        if self.is_loopback:
            return "this machine alone" + ("" if self.key is None else ", with the key")
        return "OPEN TO OTHER MACHINES that reach this one and bring the key; without TLS"
