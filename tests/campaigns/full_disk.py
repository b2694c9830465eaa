"""A study on a disk that runs full stops with one sentence, loses nothing, and goes on with space.

Run by hand, as root: python tests/campaigns/full_disk.py --designs 60 --size 500
Mounts a tmpfs of so many kB, makes it larger when the study has stopped, unmounts it in the end.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

from study_tools import coordinator, rows, said, study, total


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=60)
    parser.add_argument("--accuracy", type=float, default=0.1)
    parser.add_argument("--size", type=int, default=400, help="of the disk [kB]")
    given = parser.parse_args()
    plan = study(given.designs, given.accuracy)
    wanted = total(plan)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={given.size}k", "tmpfs", folder], check=True
        )
        try:
            store = Path(folder) / "runs.sqlite"
            process = coordinator(plan, store)
            _, errors = process.communicate()
            before = rows(store)
            sentence = " ".join(errors.split())
            print(f"     {sentence}")
            good = said(
                f"the study stops with exit code {process.returncode} after {len(before)} of {wanted} "
                "designs, with one sentence",
                good=process.returncode == 1
                and 0 < len(before) < wanted
                and sentence.startswith("Error: store: ")
                and sentence.count("Error") == 1
                and "Traceback" not in sentence,
            )
            good &= said(
                f"the store is readable on the full disk: {len(before)} rows, all done",
                good=all(row[1] == "done" for row in before),
            )
            again = coordinator(plan, store)
            _, errors = again.communicate()
            good &= said(
                f"a new start on the full disk: exit code {again.returncode}, nothing lost",
                good=again.returncode == 1
                and rows(store)[: len(before)] == before
                and "Traceback" not in errors,
            )
            print(f"     {' '.join(errors.split())}")
            before = rows(store)
            subprocess.run(["mount", "-o", f"remount,size={given.size * 20}k", folder], check=True)
            last = coordinator(plan, store)
            _, errors = last.communicate()
            after = rows(store)
            good &= said(
                f"with space the same command ends with {last.returncode}: {len(after)} of {wanted} "
                "designs",
                good=last.returncode == 0 and len(after) == wanted,
            )
            good &= said(
                f"the {len(before)} designs of before are the same rows, to the last byte",
                good=after[: len(before)] == before,
            )
        finally:
            subprocess.run(["umount", folder], check=True)
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
