"""An engine's shaft as chains of masses and as a whole crankshaft of superelements."""
