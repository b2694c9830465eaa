"""Load diagrams of crankpins and main bearings over one working cycle."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import ComplexArray, FloatArray, finite_vector, positive_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import format_number
from crankbase.summaries import summarized
from dynamics.cycle import check_even_cycle, cycle_degrees, has_closing_sample
from dynamics.engine.forces import MechanismForces, pin_groups, summed
from dynamics.engine.layout import check_distinct_positions
from dynamics.plots.load_diagrams import Frame, check_polar, draw_developed_loads, draw_polar_loads
from dynamics.plots.quantities import KILO

FEWEST_ANGLES = 3


@summarized("name", "maximum [N]", "maximum_angle_deg [deg]", "mean [N]", "angles_deg")
@dataclass(frozen=True, eq=False)
class LoadDiagram:
    """The force on one bearing over a working cycle.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Shaft angles [deg], even over one cycle, closing sample left out.
    force : complex ndarray of shape (m,)
        y - i x in the engine's frame [N]: of the rods on the crankpin, or of the main journal on its
        bearing.
    crank_angle_deg : float
        Angle of the crank that the rotating frame follows, about +z, counted from +y, when the shaft
        angle is zero [deg]: the crankpin's own; that of cylinder 1 for a main bearing.
    """

    name: str
    angles_deg: FloatArray
    force: ComplexArray
    crank_angle_deg: float

    @property
    def in_crank_frame(self) -> ComplexArray:
        """Force in the frame that turns with the crank, -Z + i T, shape (m,) [N]."""
        return np.asarray(
            self.force * np.exp(-1j * np.radians(self.crank_angle_deg + self.angles_deg))
        )

    @property
    def magnitude(self) -> FloatArray:
        """Size of the force, shape (m,) [N]."""
        return np.abs(self.force)

    @property
    def mean(self) -> float:
        """Mean size of the force over the cycle [N]."""
        return float(np.mean(self.magnitude))

    @property
    def maximum(self) -> float:
        """Largest size of the force at the sampled angles [N]."""
        return float(np.max(self.magnitude))

    @property
    def maximum_angle_deg(self) -> float:
        """Shaft angle of the largest force [deg]."""
        return float(self.angles_deg[int(np.argmax(self.magnitude))])

    def specific_pressure(self, diameter: float, length: float) -> FloatArray:
        """Return the magnitude of the force over the journal's projected area, shape (m,) [Pa].

        Parameters
        ----------
        diameter, length : float
            Of the bearing surface [m].
        """
        across = positive_number("bearing diameter", diameter, "m", "it is a length")
        along = positive_number("bearing length", length, "m", "it is a length")
        return self.magnitude / (across * along)

    def columns(self) -> dict[str, FloatArray]:
        """Return the columns of a table of the diagram, each of shape (m,), units in the names."""
        turning = self.in_crank_frame
        return {
            "shaft_angle_deg": self.angles_deg,
            "force_x_N": -self.force.imag,
            "force_y_N": self.force.real,
            "tangential_N": turning.imag,
            "radial_N": -turning.real,
            "magnitude_N": self.magnitude,
        }

    def plot(
        self, axes: Axes | None = None, *, frame: Frame | None = None, mark_step_deg: float = 30.0
    ) -> Axes:
        """Draw the polar load diagram in a frame, or the magnitude of the force over the shaft angle.

        Parameters
        ----------
        frame : {"crank", "engine"}, optional
            "crank": the locus of the force vector in the frame that turns with the crank, tangential
            force to the right, radial force (towards the shaft) down. "engine": in the fixed frame,
            seen from the free end. By default the magnitude of the force over the shaft angle.
        mark_step_deg : float, optional
            Interval of the dots on the locus in shaft angle [deg]; only with a frame.
        """
        check_polar("crank" if frame is None else frame, mark_step_deg)
        if frame is None:
            axes = new_axes(axes)
            draw_developed_loads(axes, [(self.name, self)])
            write_title(
                axes,
                f"{self.name}: mean {format_number(KILO * self.mean, 4)} kN, maximum "
                f"{format_number(KILO * self.maximum, 4)} kN",
            )
            return axes
        axes = new_axes(axes, width=6.4, height=6.4)
        draw_polar_loads(axes, [(self.name, self)], frame, mark_step_deg)
        write_title(axes, self.name)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return the force in both frames, a row for each shaft angle."""
        forces = {
            name[:-2]: (force, "N") for name, force in self.columns().items() if name[-2:] == "_N"
        }
        return table({"shaft_angle": (self.angles_deg, "deg"), **forces})


def crankpin_loads(forces: MechanismForces) -> tuple[LoadDiagram, ...]:
    """Return the load of each crankpin bearing.

    Parameters
    ----------
    forces : MechanismForces
        At even angles over one working cycle; a closing sample is left out.

    Returns
    -------
    tuple of LoadDiagram
        One for each rod on the crankshaft, in the order of the cylinders: rods side by side on one
        pin have bearings of their own, rods hinged to a main rod load its bearing.

    Raises
    ------
    InputError
        If the angles are not even over one cycle.

    Notes
    -----
    The force is that of the rod on the pin, including the rod's inertia; the pin exerts the opposite
    force on the rod's bearing.
    """
    used = _one_cycle(forces)
    diagrams = []
    for group in pin_groups(forces.engine):
        noun = "cylinder" if len(group) == 1 else "cylinders"
        numbers = " and ".join(str(number) for number in group)
        diagrams.append(
            LoadDiagram(
                f"crankpin, {noun} {numbers}",
                forces.shaft_angles_deg[:used],
                summed(forces, group)[:used],
                forces.engine.cylinders[group[0] - 1].crank_angle_deg,
            )
        )
    return tuple(diagrams)


def main_bearing_loads(
    forces: MechanismForces, bearing_positions: ArrayLike
) -> tuple[LoadDiagram, ...]:
    """Return the load of each main bearing, as if the shaft were hinged at every bearing.

    Each force acts on the two adjacent bearings according to the lever: statically determinate. A
    continuous shaft shares every load among all bearings, by its own stiffness
    and the bearings'; loads on the bearings next to the force are then usually smaller, and loads
    two bearings away not zero.

    Parameters
    ----------
    bearing_positions : array_like of shape (k,)
        Of the bearings' middles along the shaft, ascending [m].

    Returns
    -------
    tuple of k LoadDiagram
        Of the journals on their bearings. Rods load the shaft at the position of the cylinder whose
        rod is on the crankpin, rotating masses at their own. Weights are neglected.

    Raises
    ------
    InputError
        If the angles are not even over one cycle, there are fewer than two bearings, their positions
        do not ascend, a load is not between them, or cylinders are at the same position.
    """
    used = _one_cycle(forces)
    bearings = finite_vector("bearing_positions", bearing_positions)
    if bearings.size < 2 or np.any(np.diff(bearings) <= 0.0):
        raise InputError(
            f"bearing_positions: given {bearings.tolist()} m; allowed are two or more ascending "
            "positions, because every load lies between two bearings."
        )
    engine, angles = forces.engine, forces.shaft_angles_deg
    check_distinct_positions(engine)
    groups = {f"cylinder {group[0]}": group for group in pin_groups(engine)}
    places = {name: engine.cylinders[group[0] - 1].position for name, group in groups.items()}
    loads = [summed(forces, group) for group in groups.values()]
    turned = np.radians(angles)
    # A mass at r turns with it: its force on the shaft is -m r'' = m r (w^2 - i w').
    swing = forces.speed**2 - 1j * forces.crank_acceleration
    for number, mass in enumerate(engine.rotating, start=1):
        places[f"rotating mass {number}"] = mass.position
        loads.append(
            mass.static_moment * swing * np.exp(1j * (math.radians(mass.angle_deg) + turned))
        )
    for name, place in places.items():
        if not bearings[0] <= place <= bearings[-1]:
            raise InputError(
                f"{name}: position: given {place:g} m; allowed is {bearings[0]:g} to {bearings[-1]:g} m, "
                "because a load beyond the end bearings needs the shaft's stiffness to be shared."
            )
    # Bearing j takes the share of a load that a hat function has at its place.
    shares = np.array(
        [np.interp(list(places.values()), bearings, hat) for hat in np.eye(bearings.size)]
    )
    carried = shares @ np.array(loads)[:, :used]
    crank_angle = engine.cylinders[0].crank_angle_deg
    return tuple(
        LoadDiagram(f"main bearing {number}", angles[:used], force, crank_angle)
        for number, force in enumerate(carried, start=1)
    )


def _one_cycle(forces: MechanismForces) -> int:
    """Return how many of the angles are in one cycle, without the closing one."""
    degrees, cycle = forces.shaft_angles_deg, cycle_degrees(forces.engine.strokes)
    if degrees.size < FEWEST_ANGLES:
        raise InputError(
            f"shaft_angles_deg: given {degrees.size} angles; allowed are even steps over one cycle of "
            f"{cycle:g} deg, because a load's mean is taken over the cycle."
        )
    used = degrees.size - has_closing_sample(degrees, cycle)
    check_even_cycle("shaft_angles_deg", degrees[:used], cycle)
    return used
