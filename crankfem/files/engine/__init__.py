"""Engine files: what their sections say of each other; the mechanism and the throws in them."""
