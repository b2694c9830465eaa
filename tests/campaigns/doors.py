"""Change every value of every shipped file, and look whether each command answers otherwise.

Run by hand: ``python tests/campaigns/doors.py [--doors NAME ...] [--files NAME ...]``. What a door is, and
what is counted, stands in ``tests/file_doors.py``; what is left over is printed below each row.
Finite elements have coarse meshes, each throw one for all doors.
"""

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from crankfem.files.reading.data_files import shipped_names
from file_doors import DOORS, LEFT, WORDS, WRONG, beside, coarsely, look, shipped_content


def main() -> None:
    """Run the campaign and print its table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--doors", nargs="*", default=list(DOORS))
    options.add_argument("--files", nargs="*")
    asked = options.parse_args()
    coarsely()
    total: Counter[str] = Counter()
    print(f"| door | {' | '.join(WORDS)} |\n|---|{'---:|' * len(WORDS)}")
    for name in asked.doors:
        kind, *doors = DOORS[name]
        counts: Counter[str] = Counter()
        left: dict[str, set[str]] = {}
        for shipped in asked.files or shipped_names(kind):
            with tempfile.TemporaryDirectory() as folder:
                try:
                    content = shipped_content(kind, shipped)
                    beside(shipped, kind, Path(folder))
                    for change, outcome in look(doors, kind, content, Path(folder)):
                        counts[outcome] += 1
                        if outcome in (LEFT, WRONG):
                            left.setdefault(f"{change.field} {outcome}", set()).add(shipped)
                except ValueError as error:
                    print(f"{name}: {shipped} is refused: {error}", file=sys.stderr)
        total += counts
        print(f"| {name} | " + " | ".join(str(counts[word]) for word in WORDS) + " |", flush=True)
        for field, files in sorted(left.items()):
            print(f"  {field}: {', '.join(sorted(files))}", file=sys.stderr, flush=True)
    print("| all | " + " | ".join(str(total[word]) for word in WORDS) + " |")


if __name__ == "__main__":
    main()
