"""One throw: stresses at fillets, formulas compared with finite elements, export."""
