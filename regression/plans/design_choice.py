"""Which design of experiments is wished, and what it needs to know."""

from dataclasses import dataclass, fields

from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import is_whole_within
from crankbase.errors import InputError, quoted
from regression.plans.designs_factorial import ROMAN
from regression.plans.designs_surface import FACES

# A study of more finite element runs than this is a slip of the pen, and planning it takes long.
LARGEST_DESIGN = 20_000
# What each kind of design takes beside the factors.
OPTIONS: dict[str, tuple[str, ...]] = {
    "full factorial": (),
    "fractional factorial": ("resolution", "generators"),
    "central composite": ("face", "resolution"),
    "box-behnken": (),
    "latin hypercube": ("runs",),
    "sobol": ("runs",),
    "file": ("rows",),
}
SPACE_FILLING = ("latin hypercube", "sobol")


@dataclass(frozen=True)
class DesignChoice:
    """Which design, and what it needs to know.

    Parameters
    ----------
    kind : str
        A key of `OPTIONS`.
    runs : int, optional
        Number of runs of a Latin hypercube or a Sobol sequence, at most `LARGEST_DESIGN`.
    resolution : int, optional
        Of a fractional factorial (4 if neither it nor generators are given), or of the fraction of a
        central composite design's corners (all corners if not given); 3 to 8.
    generators : str, optional
        Of a fractional factorial, in place of a resolution: "a b c abc".
    face : str, optional
        Of a central composite design: "faced" (if not given), "inscribed" or "circumscribed".
    rows : tuple of tuple of float, optional
        Runs of the design "file" [SI], one value for each factor.

    Raises
    ------
    InputError
        If the kind is unknown, or something is missing, out of range or of no use to the kind.
    """

    kind: str = "full factorial"
    runs: int | None = None
    resolution: int | None = None
    generators: str | None = None
    face: str | None = None
    rows: tuple[tuple[float, ...], ...] | None = None

    def __post_init__(self) -> None:
        check_choice("study.design", self.kind, OPTIONS, "these are the designs that are known")
        for option in fields(self):
            value = getattr(self, option.name)
            takers = [kind for kind, options in OPTIONS.items() if option.name in options]
            if option.name != "kind" and value is not None and self.kind not in takers:
                raise InputError(
                    f"study.{option.name}: given {value!r} with the design {self.kind!r}; allowed is "
                    f"it with {' and '.join(takers)} only."
                )
        if "runs" in OPTIONS[self.kind] and not is_whole_within(self.runs, 1, LARGEST_DESIGN):
            given = "missing" if self.runs is None else f"given {self.runs!r}"
            raise InputError(
                f"study.runs: {given}; allowed with {self.kind!r} is a whole number from 1 to "
                f"{LARGEST_DESIGN}, because each is a finite element run, and no equation needs more."
            )
        if self.resolution is not None and self.resolution not in ROMAN:
            raise InputError(
                f"study.resolution: given {self.resolution!r}; allowed are "
                f"{', '.join(ROMAN.values())} (3 to 8)."
            )
        if self.generators is not None and not isinstance(self.generators, str):
            raise InputError(
                f"study.generators: given {quoted(self.generators)}; allowed is text in quotes, like "
                '"a b c abc".'
            )
        if self.resolution is not None and self.generators is not None:
            raise InputError(
                "study.generators: given beside study.resolution; allowed is one of the two, because "
                "generators fix the resolution."
            )
        if self.face is not None:
            check_choice("study.face", self.face, FACES, "these say where its star points stand")
        if self.kind == "file" and not self.rows:
            raise InputError("study.file: given no row; allowed is a table of one run or more.")
