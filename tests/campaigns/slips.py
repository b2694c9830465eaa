"""Change one value of a shipped engine by a factor of 1,000, 200 times, and let `check` find it.

Run by hand: ``python tests/campaigns/slips.py [COUNT] [SEED]`` (about two minutes for 200); what stays
undetected, and why, is in docs/developers/faults.md. A change counts as found if the file is
refused, or has a warning that the shipped one lacks. What values are taken for (GD2, half an angle, diameter,
degrees, pressure above ambient) is tried in tests/test_crankfem/test_input_warnings.py.
"""

import random
import re
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from crankbase.errors import InputError
from crankfem.analyses.file_check import check_file
from crankfem.files.reading.data_files import input_path, shipped_names

FACTORS = (1000.0, 0.001)
# A number with its unit in quotes, or a bare one with a decimal point; counts are no quantities.
NUMBER = re.compile(r'(?<=")-?\d+\.?\d*(?:[eE][-+]?\d+)?(?= [^"]+")|(?<== )-?\d+\.\d+(?=\s*[,}\n])')
SAID = re.compile(r'(?:source|assumed) = "[^"]*"')


def numbers(text: str) -> Iterator[re.Match[str]]:
    """Find the numbers of a file that are values other than zero, not words about them."""
    start = text.partition("\n[sources]")[0]
    quiet = re.sub(r"(?m)^#.*$", lambda line: " " * len(line.group()), start)
    quiet = SAID.sub(lambda words: "-" * len(words.group()), quiet)
    return (number for number in NUMBER.finditer(quiet) if float(number.group()))


def outcome(path: Path) -> set[str] | None:
    """Return the warnings of a file; None if it is refused."""
    try:
        return set(check_file(str(path)).warnings)
    except InputError:
        return None


def main(count: int, seed: int) -> int:
    """Print what is not found; return 1 if that is more than one in twenty."""
    draw = random.Random(seed)
    engines = {
        name: input_path(name).read_text(encoding="utf-8") for name in shipped_names("engine")
    }
    usual = {name: outcome(input_path(name)) for name in engines}
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(count):
            name = draw.choice(list(engines))
            text, factor = engines[name], draw.choice(FACTORS)
            number = draw.choice(list(numbers(text)))
            changed = f"{float(number.group()) * factor:.10g}"
            path = Path(folder) / "slip.toml"
            path.write_text(
                text[: number.start()] + changed + text[number.end() :], encoding="utf-8"
            )
            after = outcome(path)
            if after is not None and after <= (usual[name] or set()):
                line = text[text.rfind("\n", 0, number.start()) + 1 : text.find("\n", number.end())]
                missed.append(f"{name}: {number.group()} x {factor:g} in {line[:90]}")
    print(f"{count - len(missed)} of {count} found")
    print(*missed, sep="\n")
    return int(len(missed) > 0.05 * count)


if __name__ == "__main__":
    given = [int(argument) for argument in sys.argv[1:]] + [200, 1][len(sys.argv) - 1 :]
    sys.exit(main(*given))
