"""Gas: pressure over the crank angle, measured or from a cycle model, and its results.

>>> import numpy as np
>>> import crankfem as cf
>>> angle = np.arange(-360.0, 360.0, 4.0)
>>> given = 1.5e5 + 60e5 * np.exp(-(((angle - 12.0) / 23.0) ** 2))
>>> gas = cf.gas.gas_pressure(given, strokes=4, angles_deg=angle)
>>> print(f"{gas.peak_pressure / 1e5:.1f} bar at {gas.peak_angle_deg:.0f} deg")
61.5 bar at 12 deg
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
