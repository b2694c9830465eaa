"""Studies: fitted equations, their sensitivities, the compliance model."""
