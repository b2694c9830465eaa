"""The torque of an engine over its cycle, its harmonics, and how the cylinders add up by order."""
