"""A client of the service that ``crankfem serve`` starts, for other programs; no extra package is needed."""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
