"""Limits: sources, barred ranges, critical ranges, effects of uncertain values.

>>> import crankfem as cf
>>> limit = cf.limits.given_limit(
...     "torque", 2000.0, "N m", applies_to="coupling", source="maker's data sheet"
... )
>>> limit.name
'torque of coupling'
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
