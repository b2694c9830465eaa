"""Response: damping, loads of elements and their stress, Campbell diagrams.

>>> import numpy as np
>>> import crankfem as cf
>>> chain = cf.damped(cf.Chain([0.1, 0.78], [9e5]), loss_factor=0.03, source="estimate")
>>> third = cf.OrderExcitation([3.0], [100.0, 200.0], np.full((1, 2, 2), [900.0, 0.0]))
>>> loads = cf.response.element_loads(cf.forced_response(chain, third))
>>> stress = cf.response.alternating_stress(loads, [cf.response.section_modulus("torsional", 0.06)])
>>> print(f"{stress.amplitude.max() / 1e6:.1f} MPa")
19.5 MPa
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
