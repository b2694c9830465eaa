"""Engine files: checks between their sections; the mechanism and the throws in them."""
