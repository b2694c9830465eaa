"""Equations fitted to studies: forms, statistics, selection, sensitivities."""
