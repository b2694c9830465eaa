"""Measured vibration: orders from records of instruments, compared with the calculated ones and fitted."""
