"""Public names of this topic and their homes."""

from geometry.crankshaft import ShaftEnds as ShaftEnds
from geometry.crankshaft import throw_masses as throw_masses
from geometry.imported import import_throw as import_throw
from geometry.imported_shaft import ImportedCrankshaft as ImportedCrankshaft
from geometry.imported_shaft import import_crankshaft as import_crankshaft
from geometry.mass import MassProperties as MassProperties
from geometry.mass import Unbalance as Unbalance
from geometry.mass import unbalance as unbalance
from geometry.mesh import ThrowMesh as ThrowMesh
from geometry.solid_files import write_mesh as write_mesh
from geometry.solid_files import write_step as write_step
from geometry.throw_dimensions import Counterweight as Counterweight
from geometry.throw_dimensions import FurtherPin as FurtherPin
from geometry.throw_dimensions import OilHole as OilHole
from geometry.throw_dimensions import Web as Web
