"""A free-running crank under gas, load and friction: over time, over the angle, in steady running."""
