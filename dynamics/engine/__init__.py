"""Engines of any layout: positions, motion and forces of cylinders, cranks and rods."""
