"""What a classification society asks of torsional vibration: its numbers, and its tables."""
