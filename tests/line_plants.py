"""Two-stroke engines with a shaft line and propeller: as engine files, and as solids."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

import crankfem as cf
from crankfem.files.engine.engine_file import load_engine
from fem.correction import StressRecovery
from fem.material import STEEL
from fem.modes import frequencies_of
from fem.solver import assemble_mass, assemble_stiffness
from fem.symmetry import rigid_motions
from geometry.crankshaft import Crankshaft
from geometry.shapes import EDGES, FACETS
from shaft_solid import NEAR, lowest_modes, mean_motion, mesh_shaft

ENGINE = """
[engine]
name = "direct drive"
cylinders = {cylinders}
strokes = 2
bore = "{bore} m"
stroke = "{stroke} m"
rated_speed = "{speed} 1/min"
lowest_speed = "{low} 1/min"
highest_speed = "{speed} 1/min"
drives = "propeller"
crank_angles = {angles}
firing_order = {order}

[throw]
{throw}

[rod]
length = "{stroke} m"
mass = "{rods[0]} kg"
rotating_mass = "{rods[1]} kg"

[piston]
mass = "{rods[2]} kg"

[flywheel]
inertia = "{flywheel[0]} kg m^2"
mass = "{flywheel[1]} kg"

[bearings]
stiffness = "{bearing} N/m"

[thrust_bearing]
stiffness = "{thrust} N/m"
main_bearing = {last}

[shaft_line]
torsional = "torsional.toml"
axial = "axial.toml"
bearings = {places}
bearing_stiffness = "{bearing} N/m"

[propeller_forces]
blades = 4
rated_speed = "{speed} 1/min"
rated_thrust = "1000 N"
rated_torque = "1000 N m"
torque_shares = [1.0]
"""
NODE = """
[[chain.nodes]]
name = "{0}"
{1} = "{2} {3}"
"""
PIECE = """
[[chain.elements]]
nodes = ["{0}", "{1}"]
shape = "cylinder"
diameter = "{2} m"
length = "{3} m"
parts = 8
"""


@dataclass(frozen=True)
class Plant:
    """An engine and what follows it, all in SI units but for speed [1/min] and angles [deg].

    Attributes
    ----------
    rods : tuple of three float
        Mass of a rod, its rotating part, mass of a piston.
    flywheel, propeller : tuple of two float
        Polar inertia and mass.
    bearing, thrust : float
        Lateral stiffness of each bearing, also of the line; axial stiffness of the last main bearing.
    line : tuple of pairs of float
        Diameter and length of its pieces, from the flywheel on.
    supports : tuple of float
        Places of the line's bearings, as shares of its length.
    """

    throw: cf.CrankThrow
    angles: tuple
    order: tuple
    speed: float
    bore: float
    rods: tuple
    flywheel: tuple
    bearing: float
    thrust: float
    line: tuple
    propeller: tuple
    supports: tuple

    @property
    def joints(self):
        """Places of the line's ends and joints behind the flywheel [m]."""
        return np.cumsum([0.0, *(length for _, length in self.line)])

    def load(self, folder):
        """Write the engine file and its chain files, and read them."""
        dimensions = self.throw.model_dump(exclude_defaults=True)
        values = vars(self) | {
            "cylinders": len(self.angles),
            "stroke": 2.0 * self.throw.crank_radius,
            "low": 0.3 * self.speed,
            "angles": [f"{angle} deg" for angle in self.angles],
            "order": list(self.order),
            "throw": "\n".join(f'{name} = "{value} m"' for name, value in dimensions.items()),
            "last": len(self.angles) + 1,
            "places": [f"{share * self.joints[-1]} m" for share in self.supports],
        }
        (folder / "engine.toml").write_text(ENGINE.format(**values), encoding="utf-8")
        inertia, mass = self.propeller
        names = ["line flange", *(f"flange {k}" for k in range(1, len(self.line))), "propeller"]
        for kind, field, own, unit in (
            ("torsional", "inertia", inertia, "kg m^2"),
            ("axial", "mass", mass, "kg"),
        ):
            text = f'[chain]\nname = "line"\nkind = "{kind}"\n'
            for name in names:
                text += NODE.format(name, field, own if name == "propeller" else 0.0, unit)
            for left, right, piece in zip(names, names[1:], self.line, strict=False):
                text += PIECE.format(left, right, *piece)
            (folder / f"{kind}.toml").write_text(text, encoding="utf-8")
        return load_engine(folder / "engine.toml")


# Integrals of products of the shape functions of a flat 6-node triangle over its area: corners, then middles
# of the edges from the first to the second corner, and so on.
PRODUCTS = np.array(
    [
        [6, -1, -1, 0, -4, 0],
        [-1, 6, -1, 0, 0, -4],
        [-1, -1, 6, -4, 0, 0],
        [0, 0, -4, 32, 16, 16],
        [-4, 0, 0, 16, 32, 16],
        [0, -4, 0, 16, 16, 32],
    ]
)
PRODUCTS = PRODUCTS / 180.0


def face_motion(points, elements, place, diameter):
    """Rows (6, 3 n): mean motion of a round face; loads act on it as Saint-Venant's tractions."""
    near = np.abs(points[:, 2] - place) < 1e-6 * diameter
    on = near & (np.hypot(*points[:, :2].T) < 0.5 * diameter * (1.0 + 1e-6))
    edges = [set(edge) for edge in EDGES]
    facets = []
    for corners in FACETS.tolist():
        around = [4 + edges.index({corners[k], corners[(k + 1) % 3]}) for k in range(3)]
        nodes = elements[:, corners + around]
        facets.append(nodes[on[nodes].all(axis=1)])
    facets = np.concatenate(facets)
    first, second, third = (points[facets[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1)
    rows, columns = np.repeat(facets, 6, axis=1), np.tile(facets, (1, 6))
    products = (areas[:, None, None] * PRODUCTS).ravel()
    size = len(points)
    weights = sparse.coo_array((products, (rows.ravel(), columns.ravel())), shape=(size, size))
    rigid = rigid_motions(points - (0.0, 0.0, place)).reshape(-1, 6)
    weighted = sparse.kron(weights, np.eye(3)).tocsr() @ rigid
    return sparse.csr_array(np.linalg.solve(rigid.T @ weighted, weighted.T))


class LineSolid:
    """Crankshaft to the end of its last journal, flywheel there, line, propeller: one solid.

    Attributes
    ----------
    frequencies, meshed : (m,) array
        Of modes [Hz], corrected for the mesh by the energy of its error (`fem.correction`), and as it is.
    motions : (p, m) array
        Six motions of each main bearing and of the propeller, then the tangential one of each pin.
    """

    def __init__(self, plant, pin_masses, size, count, *, coupling=False, around=8):
        """Mesh and solve.

        With a coupling, the line is a body of its own that turns and moves along the shaft with the flywheel.
        """
        throw = plant.throw
        shaft = Crankshaft([throw] * len(plant.angles), crank_angles_deg=plant.angles)
        diameter, stub = throw.main_journal_diameter, 0.5 * throw.main_journal_length
        mesh = mesh_shaft(shaft, size, [(diameter, stub), *plant.line], around)
        points, elements = mesh.points, mesh.elements.copy()
        starts = shaft.starts.tolist()
        flange = starts[-1] + stub
        behind = points[elements].mean(axis=1)[:, 2] > flange
        if coupling:
            shared = np.intersect1d(elements[behind], elements[~behind])
            number = np.arange(len(points))
            number[shared] = len(points) + np.arange(len(shared))
            elements[behind] = number[elements[behind]]
            points = np.vstack((points, points[shared]))
        self.unknowns = 3 * len(points)
        self.stiffness = assemble_stiffness(points, elements, STEEL)
        self.mass = assemble_mass(points, elements, STEEL.density)

        def disc(place, diameter, half, center=(0.0, 0.0)):
            off = np.hypot(*(points[:, :2] - center).T)
            near = (np.abs(points[:, 2] - place) <= half) & (off <= 0.5001 * diameter)
            return mean_motion(points, np.flatnonzero(near), (*center, place))

        sections = [disc(place, diameter, NEAR * diameter) for place in starts]
        for section in sections:
            self._spring(section[[0, 1]], plant.bearing)
        self._spring(sections[-1][[2]], plant.thrust)
        self._body(face_motion(points, elements[~behind], flange, diameter), plant.flywheel)
        reach, (last, _) = plant.joints, plant.line[-1]
        propeller = face_motion(points, elements, flange + reach[-1], last)
        self._body(propeller, plant.propeller)
        for share in plant.supports:
            own = plant.line[int(np.searchsorted(reach, share * reach[-1])) - 1][0]
            self._spring(disc(flange + share * reach[-1], own, NEAR * own)[[0, 1]], plant.bearing)
        if coupling:
            first, stiff = plant.line[0][0], 1e3 * STEEL.youngs_modulus / reach[-1]
            one, other = (
                face_motion(points, elements[side], flange, first) for side in (~behind, behind)
            )
            self._spring((one - other)[[2]], stiff * first**2)
            self._spring((one - other)[[5]], stiff * first**4)
        pins, (pin,) = [], throw.parts.pins
        for angle, start, mass in zip(plant.angles, starts, pin_masses, strict=False):
            sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
            center = throw.crank_radius * np.array([-sine, cosine])
            middle, half = start + 0.5 * (pin.start + pin.end), 0.4 * throw.pin_length
            across = disc(middle, throw.pin_diameter, half, center)[[0, 1]]
            self._add("mass", across, mass * np.eye(2))
            pins.append(sparse.csr_array([[-cosine, -sine]]) @ across)
        rows = sparse.vstack([*sections, propeller, *pins]).tocsr()
        loads = (pins[0], propeller[[5]], propeller[[2]])
        self._shift = plant.speed / 60.0
        self._solve(rows, loads, count, points, elements)

    def _spring(self, rows, stiffness):
        self._add("stiffness", rows, stiffness * np.eye(rows.shape[0]))

    def _body(self, rows, inertia_and_mass):
        inertia, mass = inertia_and_mass
        self._add("mass", rows, np.diag([mass] * 3 + [inertia / 2.0] * 2 + [inertia]))

    def _add(self, name, rows, matrix):
        whole = rows.T @ sparse.csr_array(matrix) @ rows
        setattr(self, name, getattr(self, name) + sparse.triu(whole, format="csr"))

    def _solve(self, rows, loads, count, points, elements):
        loads = np.column_stack([load.toarray()[0] for load in loads])
        squares, shapes, grown = lowest_modes(self.stiffness, self.mass, count, loads, self._shift)
        recovery = StressRecovery(points, elements)
        errors = np.array(
            [
                recovery.energy_errors(shape.reshape(-1, 3), STEEL).elements.sum()
                for shape in shapes.T
            ]
        )
        elastic = squares > 1.0
        missing = np.divide(errors, squares, out=np.zeros(count), where=elastic)
        # As in test_short_journals.py: recovered stresses miss a part of the error's energy.
        truer = squares * (1.0 - np.maximum(1.0, 1.25 - 3.5 * missing) * missing)
        self.frequencies, self.meshed = frequencies_of(truer), frequencies_of(squares)
        self._squares = squares
        self.motions, self._work, self._grown = rows @ shapes, shapes.T @ loads, rows @ grown

    def response(self, frequency):
        """Motions (p, 3) under unit tangential force on pin 1, torque, and thrust at the propeller.

        As the mesh has them; higher modes as under loads that grow like exp(2 pi t) in a revolution, which is
        wrong by about (frequency / theirs)^2 of their part.
        """
        square, shift = ((2.0 * np.pi * value) ** 2 for value in (frequency, self._shift))
        shares = 1.0 / (self._squares - square) - 1.0 / (self._squares + shift)
        return self._grown + self.motions @ (shares[:, np.newaxis] * self._work)
