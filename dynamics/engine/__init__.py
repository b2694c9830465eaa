"""Engines of any layout: motions, forces, torque, loads, balance and free turning."""
