"""The whole crankshaft of superelements: axial, torsional and bending vibration together."""
