"""The published axial formulas, one author to a module. The face is `regression.formulas.axial_formulas`."""
