"""Strength of crankshafts by class rule UR M53: stress concentration, nominal stresses, fatigue, shrink fits.

>>> import crankfem as cf
>>> web = cf.strength.CrankWeb(0.18, 0.22, 0.17, 0.068, 0.285, 0.012, 0.012)
>>> factors = cf.strength.ConcentrationFactors(web)
>>> round(factors.alpha_bending, 3), round(factors.alpha_torsion, 3)
(2.225, 1.858)
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
