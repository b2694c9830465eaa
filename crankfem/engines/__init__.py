"""Engines: steps of an engine's vibration analysis, and the mechanism in its file.

>>> import crankfem as cf
>>> engine = cf.load_engine("6chn25-34")
>>> mechanism = cf.engines.mechanism_of(engine)
>>> len(mechanism.layout.cylinders), round(mechanism.rated_speed, 1)
(6, 52.4)
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
