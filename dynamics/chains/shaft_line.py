"""Shaft lines: pieces in a row, and the chain built from them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from crankbase.checks.arrays import nonnegative_number
from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.attachments import Propeller
from dynamics.chains.chain import Chain
from dynamics.chains.shaft_bodies import Coupling, RigidBody
from dynamics.chains.shaft_elements import Motion, ShaftCone

Piece = ShaftCone | Coupling | RigidBody | Propeller
Spreading = Literal["consistent", "lumped"]


@summarized("name", "length [m]", "mass [kg]", "polar_inertia [kg m^2]", "pieces")
@dataclass(frozen=True)
class ShaftLine:
    """Pieces of shaft, couplings, bodies and a propeller in a row, from left to right.

    Parameters
    ----------
    pieces : sequence of ShaftCone, Coupling, RigidBody or Propeller
        Bodies and propellers are at the joint given by their position in the row.
    name : str, optional
        Joints without a body are named by it and their number.

    Raises
    ------
    InputError
        If there is no piece, or an element is of another type.
    """

    pieces: Sequence[Piece]
    name: str = "shaft"

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", tuple(self.pieces))
        if not self.pieces:
            raise InputError(
                "pieces: given none; allowed are one or more, because a shaft line has pieces."
            )
        for place, piece in enumerate(self.pieces):
            if not isinstance(piece, ShaftCone | Coupling | RigidBody | Propeller):
                raise InputError(
                    f"pieces[{place}]: given {piece!r}; allowed are pieces of shaft, couplings, bodies and "
                    "propellers, because a shaft line consists of these."
                )

    @property
    def length(self) -> float:
        """Length of its pieces of shaft [m]."""
        return sum(piece.length for piece in self._shafts)

    @property
    def mass(self) -> float:
        """Mass of its pieces of shaft, without couplings and bodies [kg]."""
        return sum(piece.mass for piece in self._shafts)

    @property
    def polar_inertia(self) -> float:
        """Inertia of its pieces of shaft, without couplings and bodies [kg m^2]."""
        return sum(piece.polar_inertia for piece in self._shafts)

    @property
    def section_modulus(self) -> float:
        """Smallest torsional section modulus of its pieces of shaft [m^3].

        Raises
        ------
        InputError
            If there is no piece of shaft.
        """
        if not self._shafts:
            raise InputError(
                "pieces: given no piece of shaft; allowed are one or more, because stress belongs to a "
                "cross section."
            )
        return min(piece.section_modulus for piece in self._shafts)

    def compliance(self, kind: Motion) -> float:
        """Return the compliance from end to end [rad/(N m)] or [m/N].

        Raises
        ------
        InputError
            If the kind is unknown, or a coupling has no stiffness.
        """
        check_choice("kind", kind, get_args(Motion), "a chain is one of them")
        return sum(_compliance(piece, kind) for piece in self.pieces)

    def chain(
        self,
        kind: Motion = "torsional",
        *,
        parts: int = 1,
        inertia: Spreading = "consistent",
        loss_factor: float = 0.0,
    ) -> Chain:
        """Return the chain of the line.

        Parameters
        ----------
        kind : {"torsional", "axial"}, optional
        parts : int, optional
            Number of elements for each piece of shaft.
        inertia : {"consistent", "lumped"}, optional
            Distributed along each element, which makes frequencies too high, or half at either end,
            which makes those of a uniform shaft too low; both errors are proportional to the square of the
            element length.
        loss_factor : float, optional
            Of the pieces of shaft; couplings have their own.

        Returns
        -------
        Chain
            A row; its first node is the line's left end.

        Raises
        ------
        InputError
            If a choice is unknown, a coupling has no stiffness, or a joint between two couplings
            has no inertia.
        """
        check_choice("kind", kind, get_args(Motion), "a chain is one of them")
        check_choice("inertia", inertia, get_args(Spreading), "these are the ways to spread it")
        count = whole_number("parts", parts, 1, "a piece is at least one element")
        loss = nonnegative_number("loss_factor", loss_factor, "", "damping takes energy away")
        row = _Row()
        for piece in self.pieces:
            if isinstance(piece, ShaftCone):
                for part in piece.divided(count):
                    row.add_shaft(part, kind, loss, lumped=inertia == "lumped")
            elif isinstance(piece, Coupling):
                row.add_coupling(piece, kind)
            else:
                row.add_body(piece, kind)
        return row.chain(self.name)

    @property
    def _shafts(self) -> tuple[ShaftCone, ...]:
        return tuple(piece for piece in self.pieces if isinstance(piece, ShaftCone))


class _Row:
    """The values of a row of nodes, extended to the right."""

    def __init__(self) -> None:
        self.inertia, self.ground_damping = [0.0], [0.0]
        self.names: list[list[str]] = [[]]
        # Of each element: stiffness, damping, loss factor, inertia spread along it.
        self.elements: list[tuple[float, float, float, float]] = []

    def add_shaft(self, part: ShaftCone, kind: Motion, loss: float, *, lumped: bool) -> None:
        own = part.polar_inertia if kind == "torsional" else part.mass
        ends = own / 2.0 if lumped else 0.0
        self.inertia[-1] += ends
        self._element(1.0 / _compliance(part, kind), 0.0, loss, 0.0 if lumped else own, ends)

    def add_coupling(self, piece: Coupling, kind: Motion) -> None:
        torsional = kind == "torsional"
        self.inertia[-1] += piece.left_inertia if torsional else piece.left_mass
        right = piece.right_inertia if torsional else piece.right_mass
        damping = piece.torsional_damping if torsional else piece.axial_damping
        self._element(piece.stiffness(kind), damping, piece.loss_factor, 0.0, right)

    def add_body(self, piece: RigidBody | Propeller, kind: Motion) -> None:
        self.inertia[-1] += piece.inertia if kind == "torsional" else piece.mass
        self.names[-1].append(piece.name)
        if isinstance(piece, Propeller):
            self.ground_damping[-1] += piece.damping if kind == "torsional" else piece.axial_damping

    def chain(self, name: str) -> Chain:
        stiffness, damping, loss_factor, spread = np.array(self.elements).reshape(-1, 4).T
        return Chain(
            self.inertia,
            stiffness,
            damping=damping,
            loss_factor=loss_factor,
            ground_damping=self.ground_damping,
            distributed_inertia=spread,
            names=[
                ", ".join(own) if own else f"{name} {number}"
                for number, own in enumerate(self.names)
            ],
        )

    def _element(
        self, stiffness: float, damping: float, loss: float, spread: float, right: float
    ) -> None:
        self.elements.append((stiffness, damping, loss, spread))
        self.inertia.append(right)
        self.ground_damping.append(0.0)
        self.names.append([])


def _compliance(piece: Piece, kind: Motion) -> float:
    if isinstance(piece, ShaftCone):
        return piece.torsional_compliance if kind == "torsional" else piece.axial_compliance
    return 1.0 / piece.stiffness(kind) if isinstance(piece, Coupling) else 0.0
