"""One throw: stresses at fillets, formulas beside finite elements, export."""
