"""Excitation: forces of cylinders and propellers by order and speed, on chains.

>>> import crankfem as cf
>>> file = cf.load_mechanism("6chn25-34")
>>> forces = cf.excitation.cylinder_forces(file.layout, [30.0, 50.0], 6.0, file.pressure)
>>> forces.tangential.shape  # orders, speeds, cylinders
(12, 2, 6)
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
