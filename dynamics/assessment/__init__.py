"""Judging vibration: limits, barred speed ranges, uncertainty, damper sizes."""
