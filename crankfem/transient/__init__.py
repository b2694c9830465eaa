"""Vibration over time: steady, run-up, load steps, inertia that changes with the crank angle.

>>> import numpy as np
>>> import crankfem as cf
>>> chain = cf.Chain([0.1, 0.78], [9e5], damping=[40.0])
>>> third = cf.OrderExcitation([3.0], [100.0, 200.0], np.full((1, 2, 2), [900.0, 0.0]))
>>> motion = cf.transient.steady_motion(chain, third, speed=150.0)
>>> print(f"{motion.torque_amplitude.max():.0f} N m")
814 N m
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
