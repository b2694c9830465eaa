"""The crank mechanism at one speed: forces, loads, torque, balance."""
