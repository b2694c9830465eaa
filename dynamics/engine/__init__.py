"""Engines of any layout: where cylinders, cranks and rods are, how they move, what forces act."""
