"""Mechanism: motion of pistons and rods, forces by equilibrium, loads of pins and bearings.

>>> import numpy as np
>>> import crankfem as cf
>>> drive = cf.mechanism.SliderCrank(crank_radius=0.070, rod_length=0.265, pin_offset=0.002)
>>> drive.piston(angle_deg=[0.0, 90.0]).place.real.round(4)
array([0.335 , 0.2561])
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
