"""Compute the throws that the law is trained by, one line each; what is done is not done again.

``python benchmarks/train_law.py FOLDER --sample plain-train --count 1400 [--part 0/2] [--accuracy 0.01]``
"""

import argparse
import json
import resource
from pathlib import Path

from law_throws import SAMPLES, answers, draw


def done(folder: Path, sample: str) -> set[int]:
    """Numbers of the throws of a sample that any process has finished; a line cut off counts not."""
    found = set()
    for file in folder.glob(f"{sample}-*.jsonl"):
        for line in file.read_text(encoding="utf-8").splitlines():
            try:
                found.add(json.loads(line)["number"])
            except ValueError:
                continue
    return found


def seconds() -> float:
    """Processor time of this process and its children [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sample", choices=SAMPLES, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--part", default="0/1")
    parser.add_argument("--accuracy", type=float, default=0.01)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    part, parts = map(int, given.part.split("/"))
    finished = done(given.folder, given.sample)
    with (given.folder / f"{given.sample}-{part}.jsonl").open("a", encoding="utf-8") as file:
        file.write("\n")  # after a line cut off
        for number, fields in draw(given.sample, given.count):
            if number % parts != part or number in finished:
                continue
            start = seconds()
            row = {"sample": given.sample, "number": number, "fields": fields}
            try:
                row |= answers(fields, given.accuracy)
            except Exception as error:  # the throw is left out, with its reason
                row["failed"] = f"{type(error).__name__}: {error}"
            row["seconds"] = round(seconds() - start, 2)
            file.write(json.dumps(row) + "\n")
            file.flush()


if __name__ == "__main__":
    main()
