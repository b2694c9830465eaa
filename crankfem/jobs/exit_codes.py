"""The exit codes of the command line, and the sentence of an error."""

import errno

from crankbase.errors import InputError, MeshError, MissingLibraryError, RenderError, SolveError

EXIT_INPUT, EXIT_FAILED, EXIT_LIMITS, EXIT_UNDECIDED = range(2, 6)
EXIT_INTERRUPTED, EXIT_PIPE = 130, 141

MEANINGS = {
    0: "fine",
    EXIT_INPUT: "the input cannot be used: a file, a value, an option",
    EXIT_FAILED: "the calculation failed, or something that it needs is missing",
    EXIT_LIMITS: "with --strict: limits are exceeded",
    EXIT_UNDECIDED: "with --strict: whether limits are kept depends on assumed values",
    EXIT_INTERRUPTED: "interrupted",
    EXIT_PIPE: "the program that read the output has ended, as head does",
}


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
    from regression.records import StudyStoppedError  # here: most commands know no study

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
