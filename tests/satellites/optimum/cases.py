"""What the core's tests of every command and file do with the optimum."""

from functools import partial
from pathlib import Path

from crankfem.satellites.optimum.uses import USES as BY_FREQUENCIES

# Of a command that reads files: a line of it.
READS = {"optimum": ("optimum", "PATH", "--minimize", "web_thickness")}
# Of a line on a model: the least count of numbers that it prints.
NUMBERS_OF_A_MODEL = {
    "optimum model.json --minimize axial_compliance --limit 'web_width <= 0.301 m'": 1
}
# What it uses of files, by the name that `not_used` takes.
USES = {f"optimum {case}".rstrip(): use for case, use in BY_FREQUENCIES.items()}


def frequency(kind: str, file: Path):
    """The limit that an optimum has on an engine's first frequency, of a throw that is given."""
    from crankfem.files.engine.engine_file import load_engine
    from crankfem.satellites.optimum.frequencies import engine_frequencies
    from file_doors import Answer, named_by

    of_engine = engine_frequencies(load_engine(file))
    value = of_engine.axial(1e-9) if kind == "axial" else of_engine.torsional(3e-8)
    return Answer(value, named_by(file, f"optimum {kind}"))


# Of what commands calculate of engines: what makes parts of the answer of a file, then all of it.
DOORS = {f"optimum, {kind}": (partial(frequency, kind),) for kind in ("axial", "torsional")}
