"""The throw as a superelement: stiffness between its two end sections, and the pins' loads."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass
from fem.loads import RADIAL, pin_surfaces
from fem.solver import check_superelement
from fem.symmetry import RIGID, SectionMotions, Sections, both_ends, section_turn
from geometry.mesh import ThrowMesh

Array = NDArray[np.float64]

# Places of the unknowns of an end section.
UX, UY, UZ, RX, RY, RZ = range(6)


@dataclass(frozen=True)
class Superelement:
    """A throw condensed to the motions of its end sections.

    A single throw has rigid sections. Where throws meet its `joined` is used, with bending sections:
    2 b unknowns more, amplitudes [m] of motions of the left and then of the right section without external
    forces. With these held at zero it is the superelement of rigid sections again.

    Attributes
    ----------
    stiffness : (12, 12) array
        Unknowns ux uy uz rx ry rz of the left, then of the right end section, in the throw frame; (12 + 2 b,
        12 + 2 b) with bending sections, mean motions of the sections first.
    pin_loads : (pins, 12, 6) array
        End loads equivalent to unit forces along x, y, z on each pin, and unit moments about them at its
        center: with end forces F and loads p on pin k the end motions q satisfy
        ``stiffness @ q = F + pin_loads[k] @ p``.
    pin_flexibility : (6 pins, 6 pins) array
        Mean motions of the pins under these loads, the end sections held; motions of the ends add
        ``pin_loads[k].T @ q``.
    radials : (pins, 3) array
        Direction of a radial force on each pin, towards the shaft.
    missing : float
        For uncorrected results: their largest deficit, as a share.
    sections : SectionMotions
        Allowed motion of the sections.
    bending : Superelement or None
        For a throw with rigid sections: the same with bending sections.
    """

    stiffness: Array
    pin_loads: Array
    pin_flexibility: Array
    radials: Array
    missing: float = 0.0
    sections: SectionMotions = RIGID
    bending: "Superelement | None" = field(default=None, repr=False)

    @property
    def joined(self) -> "Superelement":
        """The superelement where throws meet: with bending sections, if the throw was solved with them."""
        return self.bending or self

    def with_sections(self, sections: Sections) -> "Superelement":
        """Return the superelement with fewer section motions where throws meet.

        Raises
        ------
        InputError
            If more are requested than the throw was solved with.
        """
        whole = self.joined
        kept = whole.sections.up_to(sections)
        if not kept.bending:
            return replace(self, bending=None)
        beyond = 12 + np.arange(kept.bending)
        own = np.r_[:12, beyond, beyond + whole.sections.bending]
        return replace(
            self,
            bending=replace(
                whole,
                stiffness=whole.stiffness[np.ix_(own, own)],
                pin_loads=whole.pin_loads[:, own],
                sections=kept,
            ),
        )

    def shared_with(self, sections: SectionMotions) -> "Superelement":
        """Return the superelement in section motions over another ring, that of a neighbor's bore."""
        if sections == self.sections:
            return self
        own = both_ends(self.sections.amplitudes_of(sections))
        return replace(
            self,
            stiffness=own.T @ self.stiffness @ own,
            pin_loads=own.T @ self.pin_loads,
            sections=sections,
        )

    @property
    def pin_load(self) -> Array:
        """End loads (12, 3) of unit forces on the first pin."""
        return np.asarray(self.pin_loads[0, :, :3])

    def end_load(self, force: Array, pin: int = 0) -> Array:
        """End loads (12,) equivalent to a force (3,) on a pin, uniformly distributed."""
        return np.asarray(self.pin_loads[pin, :, :3] @ force)

    @property
    def radial_loads(self) -> Array:
        """End loads (12, pins) of a unit radial force on each pin."""
        return np.asarray(np.einsum("pqa,pa->qp", self.pin_loads[:, :, :3], self.radials))

    @property
    def tangential_loads(self) -> Array:
        """End loads (12, pins) of a unit force on each pin in the sense of rotation about +z."""
        along = -np.cross([0.0, 0.0, 1.0], self.radials)
        return np.asarray(np.einsum("pqa,pa->qp", self.pin_loads[:, :, :3], along))

    def turned(self, *, angle_deg: float) -> "Superelement":
        """Return the superelement of the throw turned by an angle [deg] about the shaft, +z.

        The motions are then in the shaft frame; pin loads stay in the frame of the throw.
        """
        both = section_turn(self.sections, math.radians(angle_deg))
        return replace(
            self,
            stiffness=both @ self.stiffness @ both.T,
            pin_loads=both @ self.pin_loads,
            bending=None if self.bending is None else self.bending.turned(angle_deg=angle_deg),
        )


def section_rotation(angle: float) -> Array:
    """Matrix (6, 6) that turns the motions of a section by an angle [rad] about z."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.kron(np.eye(2), turn)


def combine_classes(
    classes: Sequence[CondensedClass], radials: Array = RADIAL[None]
) -> Superelement:
    """Build the superelement of a whole throw from all symmetry classes of its meshed part.

    Parameters
    ----------
    classes : sequence of CondensedClass
    radials : (pins, 3) array
        Direction of a radial force on each pin; by default that of an only pin.

    Returns
    -------
    Superelement
        With rigid sections, and with bending ones as `bending` if the classes have them.
    """
    rigid = _combined([part.up_to(RIGID) for part in classes], radials)
    if not classes[0].sections.bending:
        return rigid
    return replace(rigid, bending=_combined(classes, radials))


def checked_superelement(
    classes: Sequence[CondensedClass], radials: Array, mesh: ThrowMesh
) -> Superelement:
    """Build the superelement of `combine_classes`, and check it with rigid and with bending sections.

    Raises
    ------
    SolveError
        As `fem.solver.check_superelement` does.
    """
    made = combine_classes(classes, radials)
    centers = [pin.center for pin in pin_surfaces(mesh)]
    for one in (made, *([made.bending] if made.bending else [])):
        check_superelement(one.stiffness, one.pin_loads, mesh.length, centers)
    return made


def _combined(classes: Sequence[CondensedClass], radials: Array) -> Superelement:
    """Return one superelement of all motions that the classes have."""
    sections = classes[0].sections
    size = 2 * sections.count
    stiffness = np.zeros((size, size))
    pin_loads = np.zeros((len(radials), size, 6))
    pin_flexibility = np.zeros((6 * len(radials),) * 2)
    for part in classes:
        shares = part.shares
        stiffness += part.symmetry.copies * shares.T @ part.stiffness @ shares
        pin_loads += shares.T @ part.pin_loads
        carried = part.pin_components @ (6, 1)
        pin_flexibility[np.ix_(carried, carried)] += part.pin_flexibility
    missing = max(part.missing for part in classes)
    return Superelement(stiffness, pin_loads, pin_flexibility, radials, missing, sections)


def superelement_of_end_forces(classes: Sequence[CondensedClass], radials: Array) -> Superelement:
    """Build the superelement of a throw a second time, from the forces on its end sections alone.

    The superelement is made of strain energies and of the pins' mean motions, which gives a symmetric
    stiffness even where a solution is poor. What has to hold the end sections, under motions of them and
    under loads on the pins, follows from the same displacements without that symmetry: how far the two
    differ is how far the displacements are out of equilibrium. Work and its reverse are equal (E. Betti,
    Il Nuovo Cimento 7-8, 1872), for the two are solutions under different loads.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the meshed part.
    radials : (pins, 3) array
        Direction of a radial force on each pin.

    Returns
    -------
    Superelement
        Its stiffness is symmetric, and its pin loads are those of `combine_classes`, only as far as
        the solutions are in equilibrium.
    """
    return combine_classes(
        [replace(one, stiffness=one.end_forces, pin_loads=one.pin_reactions) for one in classes],
        radials,
    )
