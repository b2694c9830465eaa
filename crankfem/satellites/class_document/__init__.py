"""The torsional vibration document for a classification society."""
