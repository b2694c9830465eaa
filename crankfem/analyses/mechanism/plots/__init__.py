"""Diagrams of a crank mechanism: loads, torque, balance."""
