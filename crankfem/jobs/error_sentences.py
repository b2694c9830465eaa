"""Messages of errors that end a command or lose a picture, and their exit codes."""

import errno

from crankbase.errors import InputError, MeshError, MissingLibraryError, RenderError, SolveError
from crankfem.jobs.exit_codes import EXIT_FAILED, EXIT_INPUT
from regression.records import StudyStoppedError

# The environment variable that lets errors show where they come from.
TRACEBACK = "CRANKFEM_TRACEBACK"
NAMED_WRONGLY = (
    FileNotFoundError,
    FileExistsError,
    NotADirectoryError,
    IsADirectoryError,
    PermissionError,
)


def describe_error(error: Exception) -> tuple[str, int]:
    """Describe an error: return its sentence and its exit code."""
    if isinstance(error, InputError):
        return str(error), EXIT_INPUT
    if isinstance(
        error, (MissingLibraryError, RenderError, MeshError, SolveError, StudyStoppedError)
    ):
        return str(error), EXIT_FAILED
    if isinstance(error, MemoryError):
        return "The machine does not have enough memory for this.", EXIT_FAILED
    if isinstance(error, OSError):
        # What was named cannot be used, or the machine cannot do it.
        misnamed = isinstance(error, NAMED_WRONGLY) or error.errno == errno.ENAMETOOLONG
        code = EXIT_INPUT if misnamed else EXIT_FAILED
        return f"{error.filename or 'file'}: {error.strerror or error}.", code
    if isinstance(error, ImportError):
        return f"{str(error).rstrip('.')}.", EXIT_FAILED
    text = " ".join(str(error).split())
    return (
        f"{type(error).__name__}{': ' if text else ''}{text.rstrip('.')}, an unexpected error; set "
        f"{TRACEBACK}=1 to see where it comes from.",
        EXIT_FAILED,
    )
