"""Names of the ways to stand in for a rod's mass, which the command line tells before anything is loaded."""

from typing import Literal, get_args

RodModelName = Literal["rigid", "three-mass", "two-mass with inertia", "two-mass"]
ROD_MODELS: tuple[RodModelName, ...] = get_args(RodModelName)
