"""The whole crankshaft of superelements: modes, response, and its comparison with chains.

Begin with `whole_shaft(engine, analysis)`: its throws are those of `cf.analyze_throw`.

>>> from crankfem import crankshaft
>>> flywheel = crankshaft.EndBody(mass=900.0, polar_inertia=250.0, overhang=0.1)
>>> flywheel.diametral
125.0
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
