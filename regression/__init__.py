"""Designs of experiments, batch runs, fits, published formulas, lookup. Internal: import `crankfem`."""
