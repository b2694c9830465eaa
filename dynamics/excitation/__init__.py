"""Excitation of vibration by orders: cylinders, axial forces of throws, propellers."""
