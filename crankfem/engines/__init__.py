"""Engines: steps of an engine's vibration analysis, and what is assumed and unusual in its file.

>>> import crankfem as cf
>>> engine = cf.load_engine("6chn25-34")
>>> cf.engines.input_warnings(engine)
()
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
