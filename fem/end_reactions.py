"""What holds a throw's ends, and tables of it: stiffness, compliances, loads and motions by name."""

from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, Literal

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.frames import Axes, grid, table
from crankbase.results import Quantity, Result, result

MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
LOADS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
ENDS = ("left", "right")
END_MOTIONS = tuple(f"{end} {motion}" for end in ENDS for motion in MOTIONS)
END_LOADS = tuple(f"{end} {load}" for end in ENDS for load in LOADS)
# Stiffness couples forces and moments with displacements and rotations.
STIFFNESS_UNIT = "N or N m per m or rad"
MOTION_UNITS = ("m",) * 3 + ("rad",) * 3
LOAD_UNITS = ("N",) * 3 + ("N m",) * 3
WORDS: Mapping[str, tuple[str, str]] = {
    "axial_compliance": ("m/N", "axial compliance between equal neighbors"),
    "torsional_compliance": ("rad/(N m)", "torsional compliance between equal neighbors"),
    "influence_coefficient": ("m/N", "lengthening per unit radial force between equal neighbors"),
}


def compliance_table(supports: Iterable[str], **compliances: Callable[[str], float]) -> Any:
    """Return a pandas table by support of compliances, each found by the name of a support."""
    names = list(supports)
    return table(
        {"support": (names, "")}
        | {
            compliance: ([of_support(name) for name in names], WORDS[compliance][0])
            for compliance, of_support in compliances.items()
        }
    ).set_index("support")


def supported_table(answers: Mapping[str, Any]) -> Any:
    """Return a pandas table of a `SupportedThrow` each by the name of its support."""
    return compliance_table(
        answers,
        axial_compliance=lambda name: answers[name].axial,
        torsional_compliance=lambda name: answers[name].torsional,
        influence_coefficient=lambda name: answers[name].influence,
    )


def stiffness_table(stiffness: Array) -> Any:
    """Return a pandas table of a stiffness (12, 12), loads in rows and end motions in columns."""
    columns = zip(END_MOTIONS, stiffness.T, strict=True)
    return table(
        {"load": (list(END_LOADS), "")}
        | {name: (column, STIFFNESS_UNIT) for name, column in columns}
    ).set_index("load")


def motion_table(motions: Mapping[str, Array]) -> Any:
    """Return a pandas table of motions (6,) by the place that moves."""
    return _by_place(motions, MOTIONS, MOTION_UNITS)


def load_table(loads: Mapping[str, Array]) -> Any:
    """Return a pandas table of forces and moments (6,) by the place where they act."""
    return _by_place(loads, LOADS, LOAD_UNITS)


def throw_grid(stiffness: Array, gamma_deg: Array, compliances: Mapping[str, Array]) -> Any:
    """Return an xarray dataset of a stiffness (12, 12) and of compliances (n,) over angles (n,)."""
    return grid(
        {"stiffness": (("load", "motion"), stiffness, STIFFNESS_UNIT, "stiffness of the throw")}
        | {name: (("gamma_deg",), values, *WORDS[name]) for name, values in compliances.items()},
        {
            "load": (list(END_LOADS), "N or N m", "force or moment on an end section"),
            "motion": (list(END_MOTIONS), "m or rad", "motion of an end section"),
            "gamma_deg": (gamma_deg, "deg", "angle between neighboring cranks"),
        },
    )


def _by_place(rows: Mapping[str, Array], names: tuple[str, ...], units: tuple[str, ...]) -> Any:
    columns = np.array(list(rows.values())).T
    return table(
        {"place": (list(rows), "")}
        | {name: (column, unit) for name, column, unit in zip(names, columns, units, strict=True)}
    ).set_index("place")


# [N, N m] Far beyond any real load, far below what overflows.
LARGEST_LOAD = 1e30


# [m, 1] Moments and forces below this share of the largest force are round-off, and drawn as zero.
ROUND_OFF = 1e-6


@result("force", "moment", eq=True)
class EndReaction(Result):
    """Force and moment on one end section, each (3,), in the throw frame."""

    force: Annotated[Array, Quantity("N")]
    moment: Annotated[Array, Quantity("N m")]


@result(
    "left force: left.force",
    "left moment: left.moment",
    "right force: right.force",
    "right moment: right.moment",
    eq=True,
)
class Reactions(Result):
    """What supports (and under `Neighbors` the adjoining throws) exert on a throw's end sections."""

    left: EndReaction
    right: EndReaction

    def __add__(self, other: "Reactions") -> "Reactions":
        """Return the reactions to two loads at once."""
        return Reactions(
            EndReaction(self.left.force + other.left.force, self.left.moment + other.left.moment),
            EndReaction(
                self.right.force + other.right.force, self.right.moment + other.right.moment
            ),
        )

    def plot(self, axes: Axes | None = None, *, show: Literal["force", "moment"] = "force") -> Axes:
        """Draw the components of force [kN] or moment [kN m] at both ends.

        Raises
        ------
        InputError
            If `show` is neither, or these are reactions of several throws.
        """
        units = {"force": "kN", "moment": "kN m"}
        check_choice("show", show, units, "these hold the ends")
        if self.left.force.ndim != 1:
            raise InputError(
                f"plot: given reactions of {len(self.left.force)} throws; allowed are those of one, "
                "because its two ends are drawn."
            )
        from crankbase.diagrams import (  # here: a lookup draws nothing
            draw_groups,
            new_axes,
            write_title,
        )

        axes = new_axes(axes)
        ends = {"left": self.left, "right": self.right}
        vectors = {name: getattr(end, show) for name, end in ends.items()}
        noise = ROUND_OFF * max(float(np.abs(end.force).max()) for end in ends.values())
        sizes = {
            name: np.where(np.abs(vector) > noise, vector, 0.0) / 1e3
            for name, vector in vectors.items()
        }
        draw_groups(axes, ("x", "y", "z"), sizes, f"{show} [{units[show]}]")
        write_title(axes, f"Reactions: {show}s on the ends")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of forces and moments Fx to Mz at the left and the right end.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        ends = {"left": self.left, "right": self.right}
        return load_table(
            {
                name: np.concatenate([reaction.force, reaction.moment])
                for name, reaction in ends.items()
            }
        )
