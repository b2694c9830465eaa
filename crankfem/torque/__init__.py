"""Torque: star diagrams, forces of one cylinder on its pin, a crank that turns freely.

>>> import crankfem as cf
>>> file = cf.load_mechanism("6chn25-34")
>>> third, half = cf.torque.star_diagram(file.layout, [3.0, 3.5])
>>> third.kind, round(third.share, 6)  # all six cylinders pull one way
('major', 1.0)
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
