"""Measurements: orders from records of vibration, compared with an engine's.

>>> import crankfem as cf
>>> wheel = cf.measurements.Wheel.read("60-2")
>>> wheel.missing, wheel.highest_order
(2, 30.0)
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
