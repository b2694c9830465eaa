"""A table as columns over rows of SI values, the units it is shown in, and data frames."""
