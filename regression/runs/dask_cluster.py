"""The workers of a Dask cluster, as a study's coordinator sees them."""

import contextlib
import logging
import re
import threading
import uuid
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from importlib import import_module
from typing import Any

from crankbase.calls import Limits
from crankbase.errors import InputError, MissingLibraryError
from regression.records import StudyStoppedError
from regression.runs.cluster import Task, TaskLostError, compute_design, end_run, identity

# Seconds to wait for the scheduler to answer, and for a result that it says is there.
CONNECT, FETCH = 10.0, 30.0
# Results that are fetched at a time.
FETCHERS = 16
# Schemes of Dask's addresses; one within a process alone is none that a study could share.
ADDRESS = re.compile(
    r"(?:(?:tcp|tls|ucx|ucxx|ws|wss)://)?(?:[\w.-]+|\[[0-9A-Fa-f:.%]+\]):(\d{1,5})"
)


class _DaskTask:
    """A design in progress as a future of Dask, whose result is fetched in a separate thread.

    Dask may report a result just when it has been lost with its worker, and then wait for it:
    only that thread waits.
    """

    def __init__(self, place: str, future: Any, fetchers: Executor, fetched: Callable[[], None]):
        self._place, self._future, self._fetched = place, future, fetched
        self._found: dict[str, Any] | Exception | None = None

        def fetch_later(_: Any) -> None:
            with contextlib.suppress(RuntimeError):  # the cluster has been left
                fetchers.submit(self._fetch)

        future.add_done_callback(fetch_later)

    def done(self) -> bool:
        return self._found is not None

    def result(self) -> dict[str, Any]:
        assert self._found is not None
        if isinstance(self._found, Exception):
            raise self._found
        return self._found

    def release(self) -> None:
        with contextlib.suppress(Exception):  # the scheduler may be gone
            if self.done():
                self._future.release()
            else:
                self._future.cancel()

    def _fetch(self) -> None:
        try:
            self._found = self._future.result(timeout=FETCH)
        except (ImportError, AttributeError) as error:
            self._found = InputError(
                f"dask: given a cluster whose worker {self._place} cannot load crankfem ({error}); allowed "
                "are workers with the same crankfem as the coordinator's."
            )
        except Exception as error:  # whatever Dask says of a worker that is gone
            self._found = TaskLostError(
                f"the result was lost with its worker ({type(error).__name__}: {error})"
            )
        self._fetched()


def silence_dask_log() -> None:
    """Silence Dask's own log: what matters of it is said by us, in sentences."""
    with contextlib.suppress(ImportError):
        import_module("distributed")  # sets the levels of its loggers when it is first loaded
    for name in list(logging.root.manager.loggerDict):
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def check_address(address: object) -> str:
    """Return the address of a Dask scheduler if it has the form of one: ``tcp://10.0.0.1:8786``.

    Raises
    ------
    InputError
    """
    found = ADDRESS.fullmatch(address) if isinstance(address, str) else None
    if not isinstance(address, str) or found is None or not 1 <= int(found[1]) <= 65535:
        raise InputError(
            f"dask: given {address!r}; allowed is the address of a running Dask scheduler, like "
            "tcp://10.0.0.1:8786: a host and a port, with tcp, tls, ucx, ws or wss in front."
        )
    return address


class DaskCluster:
    """The workers of a Dask cluster.

    Parameters
    ----------
    address : str
        Of its scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    InputError
        If this is not an address, or no scheduler responds there.
    MissingLibraryError
        If the package distributed is not installed.
    """

    def __init__(self, address: str) -> None:
        check_address(address)
        try:
            from distributed import Client
        except ImportError:
            raise MissingLibraryError(
                "dask: given, but the package distributed is not installed; install it with: "
                "pip install 'crankfem[cluster]'"
            ) from None
        self.address = address
        self.run = uuid.uuid4().hex[:12]
        self._tasks = 0
        self._wake = threading.Event()
        self._fetchers = ThreadPoolExecutor(FETCHERS, thread_name_prefix="crankfem-fetch")
        # Made in two steps: a client that fails halfway must be closed, or it complains when it is
        # collected.
        client: Any = Client.__new__(Client)
        self._client = client
        try:
            client.__init__(address, timeout=CONNECT, set_as_default=False, name="crankfem")
        except (OSError, ValueError, TypeError) as error:
            self.close()
            why = f"nothing answers there ({type(error).__name__})"
            if address.startswith("tls"):
                why += ", or not to the certificate that Dask's configuration names on this machine"
            raise InputError(
                f"dask: given {address!r}; allowed is the address of a running Dask scheduler, like "
                f"tcp://10.0.0.1:8786, because {why}."
            ) from None

    def places(self) -> dict[str, bool]:
        """List the addresses of the workers, and whether each accepts designs."""
        try:
            workers = self._client.scheduler_info(n_workers=-1)["workers"]
        except Exception:  # whatever Dask says when it loses its scheduler
            raise self._gone() from None
        if self._client.status not in ("running", "connecting"):
            raise self._gone()
        return {address: about["status"] == "running" for address, about in workers.items()}

    def submit(self, place: str, request: Mapping[str, Any], limits: Limits) -> Task:
        """Assign a design to a worker."""
        self._tasks += 1
        future = self._client.submit(
            compute_design,
            self.run,
            request,
            limits,
            identity(),
            workers=[place],
            allow_other_workers=False,
            pure=False,
            retries=0,
            key=f"crankfem-{self.run}-{self._tasks}",
        )
        return _DaskTask(place, future, self._fetchers, self._wake.set)

    def wait(self, seconds: float) -> None:
        """Wait until a task may be done, up to a time."""
        self._wake.wait(seconds)
        self._wake.clear()

    def close(self) -> None:
        """Leave the cluster; designs in progress for this run are ended."""
        with contextlib.suppress(Exception):  # the scheduler may be gone
            if self._client.status == "running":
                self._client.run(end_run, self.run, wait=False, on_error="ignore")
        self._fetchers.shutdown(wait=False, cancel_futures=True)
        with contextlib.suppress(Exception):
            self._client.close(timeout=CONNECT)

    def _gone(self) -> StudyStoppedError:
        return StudyStoppedError(
            f"dask: the scheduler at {self.address} is gone; finished designs are kept, and the same "
            "command continues when it is back."
        )
