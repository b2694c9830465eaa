"""Hinges: the pneumatic hinge for constant crank speed, its moment, guides and flywheel.

>>> import crankfem as cf
>>> spring = cf.hinges.GasSpring(piston_area=0.02, height=0.3, pressure=6e5)
>>> file = cf.hinges.load_hinge("crosshead-30-100")
>>> round(file.engine.crank_radius, 3)
0.5
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
