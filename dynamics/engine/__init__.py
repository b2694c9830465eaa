"""Engines of any layout: positions, motion and forces of cylinders, cranks and rods."""

from typing import Literal, get_args

# Models of a rod's mass; here, for the command line before anything else is loaded.
RodModelName = Literal["rigid", "three-mass", "two-mass with inertia", "two-mass"]
ROD_MODELS: tuple[RodModelName, ...] = get_args(RodModelName)
