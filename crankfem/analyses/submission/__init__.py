"""The torsional vibration document for a classification society: its numbers and tables."""
