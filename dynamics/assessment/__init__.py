"""Judging vibration: limits, barred speed ranges, uncertainty, and dampers that suffice."""
