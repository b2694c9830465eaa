"""A study on a Dask cluster, one of whose workers is killed, gives the table of the local run.

Run by hand: python tests/campaigns/dask_study.py --designs 24 --accuracy 0.1
The cluster is a LocalCluster of two processes that talk over TCP. Prints the largest difference of any
response; exit code 1 if it is more than 1e-10 of the value.
"""

import argparse
import os
import signal
import tempfile
import time
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster
from study_tools import environment, said, study, total

from regression.runs.study import run_plan

ALLOWED = 1e-10


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=24)
    parser.add_argument("--accuracy", type=float, default=0.1)
    given = parser.parse_args()
    os.environ |= environment()  # the cluster's processes must find the packages
    plan = study(given.designs, given.accuracy)
    wanted = total(plan)
    killed: list[int] = []
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            protocol="tcp://",
            host="127.0.0.1",
            dashboard_address=None,
        ) as cluster,
    ):
        address = cluster.scheduler_address
        with Client(address) as client:
            processes = list(client.run(os.getpid).values())

        def progress(finished: int, _total: int, _newest: object) -> None:
            if finished == wanted // 3 and not killed:
                killed.append(processes[0])
                os.kill(processes[0], signal.SIGKILL)

        notes: list[str] = []
        began = time.monotonic()
        far = run_plan(
            plan, Path(folder) / "far.sqlite", 1, progress, dask=address, note=notes.append
        )
        seconds = time.monotonic() - began
        began = time.monotonic()
        near = run_plan(plan, Path(folder) / "near.sqlite", 2)
        print(f"     cluster {seconds:.1f} s, local {time.monotonic() - began:.1f} s")
        for note in notes:
            print(f"     {note}")
    good = said(
        f"a Dask worker was killed after {wanted // 3} of {wanted} designs", good=bool(killed)
    )
    good &= said(
        f"{len(far.values)} designs on the cluster, {len(near.values)} here, failures "
        f"{len(far.failures)} and {len(near.failures)}",
        good=len(far.values) == len(near.values) == wanted,
    )
    if not good:
        for failure in (*far.failures, *near.failures):
            print(f"     {failure}")
        return 1
    assert np.array_equal(far.values, near.values)
    off = {
        name: float(np.max(np.abs(far.responses[name] / column - 1.0)))
        for name, column in near.responses.items()
    }
    worst = max(off, key=lambda name: off[name])
    good &= said(
        f"the tables differ by {off[worst]:.1e} at most ({worst})", good=off[worst] <= ALLOWED
    )
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
