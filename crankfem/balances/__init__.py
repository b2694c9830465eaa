"""Balance: forces and moments by order, counterweights, hodographs, hinged rods; `cf.balance` combines them.

>>> import crankfem as cf
>>> ellipse = cf.balances.Hodograph(order=2, forward=300.0, backward=100.0)
>>> ellipse.major, ellipse.minor, ellipse.sense
(400.0, 200.0, 1)
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
