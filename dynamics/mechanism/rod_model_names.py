"""Names of the models of a rod's mass, for the command line before anything else is loaded."""

from typing import Literal, get_args

RodModelName = Literal["rigid", "three-mass", "two-mass with inertia", "two-mass"]
ROD_MODELS: tuple[RodModelName, ...] = get_args(RodModelName)
