"""The elastic hinge of a two-stroke engine."""
