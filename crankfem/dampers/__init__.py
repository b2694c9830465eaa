"""Dampers: viscous, rubber, axial; their optimum tuning, and their size for a limit.

>>> import crankfem as cf
>>> chain = cf.Chain([0.1, 0.78], [9e5])
>>> best = cf.dampers.untuned_optimum(0.5)
>>> damper = cf.dampers.ViscousDamper(ring_inertia=0.05, damping=20.0)
>>> len(cf.chains.with_damper(chain, 0, damper).inertia)
3
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
