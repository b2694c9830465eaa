"""Studies: the table of the runs, the equations fitted to it, the best throw under limits.

`cf.run_study` returns table and equations, and the `cf.ComplianceModel` in which an optimum is sought:

>>> import crankfem as cf
>>> limit = cf.studies.Limit(("axial_compliance",), at_most=1.2e-9, name="pull")
>>> limit.name, limit.bound
('pull', 1.2e-09)

``cf.studies.find_optimum(model, "mass", [limit])`` then returns the throw; `best_throw` finds that of an
engine by finite elements, without a study.
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
