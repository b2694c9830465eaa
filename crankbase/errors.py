"""The errors that a user of crankfem meets: each one is a single clear sentence."""


class InputError(ValueError):
    """Input that cannot be used; the message names the field, the value, the allowed range and why."""


class MissingLibraryError(ImportError):
    """A system library or Python package is missing; the message names the package to install."""


class MeshError(RuntimeError):
    """A throw could not be meshed, although its dimensions are valid; the message says why."""


class RenderError(RuntimeError):
    """A picture could not be rendered, although everything that is needed is there; the message says why."""
