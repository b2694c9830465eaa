"""Records as instruments write them: channels with their units, over time or crank angle."""
