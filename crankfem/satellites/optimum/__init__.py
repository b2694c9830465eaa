"""The optimum: the smallest dimension or response of a throw under limits, by a model or finite elements."""
