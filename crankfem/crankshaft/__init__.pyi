"""Public names of this topic and their homes."""

from crankfem.analyses.shaft.whole_shaft import ShaftComparison as ShaftComparison
from crankfem.analyses.shaft.whole_shaft import shaft_response as shaft_response
from crankfem.analyses.shaft.whole_shaft import shaft_throws as shaft_throws
from crankfem.analyses.vibration.bearing_sweep import BearingSweep as BearingSweep
from dynamics.chains.dampers import TorsionalRing as TorsionalRing
from dynamics.crankshaft.assembly import assemble_crankshaft as assemble_crankshaft
from dynamics.crankshaft.chain_comparison import ChainVerdict as ChainVerdict
from dynamics.crankshaft.chain_comparison import ModeMatch as ModeMatch
from dynamics.crankshaft.chain_comparison import ResponseMatch as ResponseMatch
from dynamics.crankshaft.coupled_response import CoupledResponse as CoupledResponse
from dynamics.crankshaft.coupled_response import SplitMotion as SplitMotion
from dynamics.crankshaft.coupled_response import coupled_response as coupled_response
from dynamics.crankshaft.shaft_modes import ShaftModes as ShaftModes
from dynamics.crankshaft.shaft_modes import crankshaft_modes as crankshaft_modes
from dynamics.crankshaft.shaft_modes import crankshaft_system as crankshaft_system
from dynamics.crankshaft.surroundings import AxialSupport as AxialSupport
from dynamics.crankshaft.surroundings import EndBody as EndBody
from dynamics.crankshaft.surroundings import MainBearings as MainBearings
from dynamics.crankshaft.surroundings import ShaftSurroundings as ShaftSurroundings
from dynamics.crankshaft.surroundings import ShaftThrow as ShaftThrow
