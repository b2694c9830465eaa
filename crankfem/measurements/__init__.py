"""Measurements: orders from records of vibration, compared with an engine's.

>>> import crankfem as cf
>>> cf.measurements.Wheel.read("60-2").missing
2
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
