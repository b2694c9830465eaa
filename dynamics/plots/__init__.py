"""Diagrams of results: functions of plain numbers that draw on given axes."""
