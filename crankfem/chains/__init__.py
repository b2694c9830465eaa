"""Chains: editing and joining, gears, shafts by theory, ground; text; critical speeds.

>>> import crankfem as cf
>>> chain = cf.Chain([0.1, 0.78], [9e5])
>>> chain = cf.chains.with_inertia(chain, 1, 0.2)
>>> chain.inertia
array([0.1 , 0.98])
>>> found = cf.chains.critical_speeds(chain.modes().frequencies, [6.0, 12.0], (100.0, 600.0))
>>> [round(one.speed_rpm) for one in found]
[2506, 5012]
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
