"""Throws: counterweights, webs of their own, further pins, masses, meshes, solids.

>>> import crankfem as cf
>>> weight = cf.throws.Counterweight(outer_radius=0.270, angle=1.8)
>>> throw, _ = cf.load_throw("6chn25-34")
>>> throw = throw.changed(counterweight=weight)
>>> round(throw.volume, 4)
0.0305
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
