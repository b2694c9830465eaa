"""Published formulas: one by name, all in a table, as bars, over the angle of the next crank.

>>> import crankfem as cf
>>> throw, _ = cf.load_throw("6chn25-34")
>>> found = cf.formulas.axial_formula("TsNIIMF", throw)
>>> print(f"{found.value:.2e} {found.unit}, valid: {found.valid}")
1.60e-09 m/N, valid: True
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
