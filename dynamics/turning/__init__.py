"""A crank left to turn under gas, load and friction: over time, over the angle, steadily."""
