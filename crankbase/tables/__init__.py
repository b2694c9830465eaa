"""A table as columns over rows of SI values, its display units, and data frames."""
