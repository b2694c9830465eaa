"""Compliance and stress by finite elements: axial alone, whole shafts, fillets, natural modes.

`cf.analyze_throw` does most of it for one throw; this topic has the rest.

>>> import crankfem as cf
>>> throw, _ = cf.load_throw("6chn25-34")
>>> found = cf.compliance.analyze_axial(throw, accuracy=0.05)
>>> print(f"{found.axial_compliance('guided'):.1e} m/N")
2.6e-10 m/N
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
