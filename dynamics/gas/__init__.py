"""Gas pressure in a cylinder: measured, from a cycle model, and the work it does."""
