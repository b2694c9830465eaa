"""A crank that turns freely under gas, load and friction: over time, over the angle, steadily."""
