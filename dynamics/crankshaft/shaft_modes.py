"""The linear system of a whole crankshaft and its modes, by axial, torsional and bending shares."""

from dataclasses import field, replace

import numpy as np

from crankbase.array_checks import Array, positive_number, positive_vector
from crankbase.choices import check_choice, whole_within
from crankbase.diagrams import draw_diagram, legend_inside, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, Dataset, grid, table
from crankbase.results import Hertz, Number, Result, result
from dynamics.chains.engine_chains import CRANKSHAFT_MODE
from dynamics.crankshaft.assembly import CLASSES, AssembledShaft
from dynamics.crankshaft.surroundings import RZ, UZ
from dynamics.plots.curves import name_axis
from dynamics.plots.mode_shapes import shaft_shape
from dynamics.response.linear_system import LinearSystem, natural_modes

# A mode is called pure above this share of one class.
PURE = 0.95


@result("name", "frequency", "label", eq=True)
class ShaftMode(Result):
    """A natural mode of a whole crankshaft, with the shares of its energy."""

    name: str
    frequency: Hertz
    rigid: bool
    kind: str
    label: str
    axial: Number
    torsional: Number
    bending: Number


@result("frequencies [Hz]", "rigid", "names")
class ShaftModes:
    """Natural modes, ascending: rigid motions first, then all elastic modes.

    Attributes
    ----------
    angular_frequencies : (q,) array
        [rad/s]; exactly 0 for rigid motions.
    shapes : (u, q) array
        Of the unknowns; rigid motions of unit translation or rotation, elastic modes of unit modal mass.
    rigid : int
        Number of rigid motions.
    names : tuple of q str
        Name of the rigid motion; "mode 1" and so on for elastic modes.
    shares : (3, q) array
        Axial, torsional and bending shares of the energy, with the sum 1; see `Stations.energy_shares`.
    crankshaft_shares : (q,) array
        Share of the strain energy outside the damper's spring, the coupling of a driven machine and the
        shaft line; 1 for rigid motions.
    motions : (s, 6, q) array
        Of the stations: displacements, rotations, in the shaft's frame.
    positions : (s,) array
        Of the stations along the shaft [m].
    """

    angular_frequencies: Array
    shapes: Array = field(repr=False)
    rigid: int
    names: tuple[str, ...]
    shares: Array
    crankshaft_shares: Array
    motions: Array = field(repr=False)
    positions: Array = field(repr=False)

    @property
    def frequencies(self) -> Array:
        """Natural frequencies [Hz], (q,)."""
        return self.angular_frequencies / (2.0 * np.pi)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The class with the largest share of each mode, "axial", "torsional" or "bending"."""
        return tuple(CLASSES[place] for place in np.argmax(self.shares, axis=0))

    def label(self, mode: int) -> str:
        """Describe a mode, the lowest being 0: its classes with 5 % or more, the largest first.

        Raises
        ------
        InputError
            If there is no such mode.
        """
        why = "so many modes are kept, the lowest first"
        shares = self.shares[:, whole_within("mode", mode, 0, self.shares.shape[1] - 1, why)]
        shown = (kind for kind in np.argsort(-shares) if shares[kind] >= 1.0 - PURE)
        return ", ".join(f"{CLASSES[kind]} {100.0 * shares[kind]:.0f} %" for kind in shown)

    def described(self, mode: int) -> ShaftMode:
        """Return one of them, the lowest being 0."""
        return ShaftMode(
            self.names[mode],
            float(self.frequencies[mode]),
            mode < self.rigid,
            self.kinds[mode],
            self.label(mode),
            *self.shares[:, mode].tolist(),
        )

    def first(self, kind: str) -> int | None:
        """Return the lowest elastic mode of the crankshaft itself in which a class has the largest share.

        Modes of a coupling, a damper's ring or a shaft line, with more than half of the strain energy in
        its springs, are skipped. None if there is no other.

        Raises
        ------
        InputError
            If there is no such class.
        """
        check_choice("kind", kind, CLASSES, "modes are of these kinds")
        of_cranks = self.crankshaft_shares[self.rigid :] >= CRANKSHAFT_MODE
        modes = np.flatnonzero(of_cranks & (np.array(self.kinds[self.rigid :]) == kind))
        return self.rigid + int(modes[0]) if modes.size else None

    def plot(
        self, axes: Axes | None = None, *, mode: int | None = None, radius: float | None = None
    ) -> Axes:
        """Draw the shape of one mode along the shaft.

        Parameters
        ----------
        mode : int, optional
            Its number, as in the arrays, rigid motions included; the first elastic one by default.
        radius : float, optional
            Crank radius, at which rotation about the shaft is shown as displacement [m]; without it
            nothing can be drawn.

        Raises
        ------
        InputError
            If there is no such mode, or no radius.
        """
        mode = self.rigid if mode is None else mode
        whole_within("mode", mode, 0, len(self.names) - 1, "the shaft has that many modes")
        if radius is None:
            raise InputError(
                "radius: given none; allowed is the crank radius in m, because rotation about the shaft is "
                "shown as the displacement there."
            )
        arm = positive_number("radius", radius, "m", "rotation is shown as displacement there")
        along = np.argsort(self.positions, kind="stable")
        axes = new_axes(axes)
        draw_diagram(axes, shaft_shape(self.positions[along], self.motions[along, :, mode], arm))
        write_title(axes, f"{self.frequencies[mode]:.1f} Hz: {self.label(mode)}")
        legend_inside(axes)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return one row for each mode: name, frequency, and shares of its energy.

        Units and errors are those of `crankbase.frames.table`.
        """
        return table(
            {
                "mode": (list(self.names), ""),
                "frequency": (self.frequencies, "Hz"),
                "kind": (list(self.kinds), ""),
                **{name: (share, "1") for name, share in zip(CLASSES, self.shares, strict=True)},
            }
        )

    def to_xarray(self) -> Dataset:
        """Return frequencies, energy shares and the motions of all stations.

        Units and errors are those of `crankbase.frames.grid`.
        """
        over = ("station", "axis", "mode")
        return grid(
            {
                "frequency": (("mode",), self.frequencies, "Hz", "natural frequency"),
                "shares": (("kind", "mode"), self.shares, "1", "share of the energy"),
                "displacement": (over, self.motions[:, :3], "m", "displacement of the station"),
                "rotation": (over, self.motions[:, 3:], "rad", "rotation of the station"),
                "position": (("station",), self.positions, "m", "position along the shaft"),
            },
            {
                "mode": name_axis(self.names, "mode"),
                "kind": name_axis(CLASSES, "kind of motion"),
                "axis": name_axis(("x", "y", "z"), "axis of the shaft's frame"),
            },
        )


def crankshaft_modes(shaft: AssembledShaft) -> ShaftModes:
    """Find all natural modes of a crankshaft without its damping."""
    natural, shapes = natural_modes(shaft.mass, shaft.stiffness, shaft.rigid)
    rigid = shaft.rigid.shape[1]
    # Of rigid motions any combinations are modes; the plain ones have names.
    shapes = np.column_stack((shaft.rigid, shapes[:, rigid:]))
    elastic = natural.size - rigid
    beside = np.sum((shaft.added_springs @ shapes) ** 2, axis=0)
    beside[rigid:] /= natural[rigid:] ** 2  # elastic modes are of unit modal mass
    return ShaftModes(
        angular_frequencies=natural,
        shapes=shapes,
        rigid=rigid,
        names=(*shaft.rigid_names, *(f"mode {number + 1}" for number in range(elastic))),
        shares=shaft.stations.energy_shares(shapes, shaft.added_mass),
        crankshaft_shares=1.0 - beside,
        motions=np.einsum("siu,uk->sik", shaft.stations.motions, shapes),
        positions=shaft.stations.positions,
    )


def rotation_ratio(speed: float, angular_frequencies: Array) -> Array:
    """Return speed of rotation over natural frequency, which shows the effect of the rotating frame.

    Parameters
    ----------
    speed : float
        Of the shaft [rad/s].
    angular_frequencies : ndarray of shape (m,)
        Of elastic modes [rad/s], above zero.

    Returns
    -------
    ndarray of shape (m,)
        r. A bending mode that is alike in both planes has the frequencies w (1 +- r) in the rotating
        frame, w in the fixed one. On the lateral part of torsional and axial modes act Coriolis
        forces of the relative size 2 r and centrifugal forces of r^2, which change a frequency by about
        r^2 times the share of lateral motion.
    """
    return speed / positive_vector(
        "angular_frequencies", angular_frequencies, "rad/s", "rigid motions have no ratio"
    )


# Corrections of which the others compose all but this share are left out.
INDEPENDENT = 1e-10


@result("modes.frequencies [Hz]", "kept", "highest_frequency [Hz]")
class CrankshaftSystem:
    """A whole crankshaft, prepared for forced vibration.

    Attributes
    ----------
    modes : ShaftModes
        Of all unknowns, before modes are left out.
    system : LinearSystem
        Its points are the sections (six motions each), the pins (three each, along the tangential and the
        radial force and along the shaft), and damper ring and driven machine, as in `names`.
    kept : int
        Elastic modes kept.
    corrections : int
        Static shapes that replace the modes left out.
    highest_frequency : float or None
        Up to which modes were kept [Hz]; None for all.
    momenta : (n + 1, q) array
        `AssembledShaft.momenta` per unknown of the system.
    """

    shaft: AssembledShaft
    modes: ShaftModes
    system: LinearSystem
    kept: int
    corrections: int
    highest_frequency: float | None
    momenta: Array = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the points, row by row."""
        return self.shaft.names

    def point(self, name: str) -> int:
        """Return the row of a point such as "main bearing 1 uz" or "pin 1 radial".

        Raises
        ------
        InputError
            If there is none of that name.
        """
        check_choice("point", name, self.names, "these points of the shaft have names")
        return self.names.index(name)


def crankshaft_system(
    shaft: AssembledShaft, highest_frequency: float | None = None
) -> CrankshaftSystem:
    """Build the linear system of a crankshaft from its lower modes.

    Parameters
    ----------
    highest_frequency : float, optional
        Modes up to this are kept [Hz]; all by default.

    Raises
    ------
    InputError
        If the frequency is not above zero.

    Notes
    -----
    The modes left out act like springs. Their static response to a unit force at each point where
    forces act (pins, axial forces and torques at both ends, dashpots) is kept as one more shape. So
    the response to constant forces there stays exact at every point of the shaft, and in vibration
    the error is proportional to the fourth power of frequency over that of the lowest mode left out.
    """
    modes = crankshaft_modes(shaft)
    rigid = modes.rigid
    if highest_frequency is None:
        cut = len(modes.frequencies)
    else:
        positive_number("highest_frequency", highest_frequency, "Hz", "modes are kept up to it")
        cut = max(rigid, int(np.count_nonzero(modes.frequencies <= highest_frequency)))
    # Static responses (u, c) of the modes left out, of unit mass and orthogonal to each other.
    corrections = left_out = modes.shapes[:, cut:]
    if left_out.shape[1]:
        last = 6 * (shaft.section_count - 1)
        ends = shaft.sections[[UZ, RZ, last + UZ, last + RZ]]
        loads = np.vstack((shaft.pins, ends, shaft.dashpots, shaft.added))
        # In the modes left out: amplitudes (modes, loads), each load scaled to an answer of unit mass.
        answers = (left_out.T @ loads.T) / modes.angular_frequencies[cut:, np.newaxis] ** 2
        sizes = np.linalg.norm(answers, axis=0)
        answers = answers[:, sizes > 0.0] / sizes[sizes > 0.0]
        directions, singular, _ = np.linalg.svd(answers, full_matrices=False)
        corrections = left_out @ directions[:, singular > INDEPENDENT * singular[0]]
    elastic = np.hstack((modes.shapes[:, rigid:cut], corrections))
    basis = np.hstack((shaft.rigid, elastic))
    mass, stiffness = (basis.T @ matrix @ basis for matrix in (shaft.mass, shaft.stiffness))
    natural, shapes = natural_modes(mass, stiffness, np.eye(len(mass))[:, :rigid])
    # Amplitudes of the modes are the unknowns: then no digits are lost between stiff and soft ones.
    basis = basis @ shapes
    unit = np.eye(len(natural))
    return CrankshaftSystem(
        shaft=shaft,
        modes=modes,
        system=LinearSystem(
            mass=unit,
            stiffness=np.diag(natural**2),
            damping=basis.T @ shaft.damping @ basis,
            loss=basis.T @ shaft.loss @ basis,
            rigid=unit[:, :rigid],
            expand=shaft.expand @ basis,
            natural=natural,
            shapes=unit,
            varying=tuple(replace(spring, row=spring.row @ basis) for spring in shaft.varying),
        ),
        kept=cut - rigid,
        corrections=corrections.shape[1],
        highest_frequency=highest_frequency,
        momenta=shaft.momenta @ basis,
    )
