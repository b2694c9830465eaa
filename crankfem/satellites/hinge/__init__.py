"""The elastic hinge that keeps a crank's speed constant."""
