"""The torque of an engine over its cycle, its harmonics, and the sum over the cylinders by order."""
