"""Kinematics of the crank mechanism and the masses of its rods."""
