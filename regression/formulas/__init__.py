"""The published axial formulas, one author per module. Use `regression.formulas.axial_formulas`."""
