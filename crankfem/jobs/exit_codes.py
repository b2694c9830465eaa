"""The exit codes of the command line, and what each means."""

EXIT_INPUT, EXIT_FAILED, EXIT_LIMITS, EXIT_UNDECIDED, EXIT_INTERRUPTED, EXIT_PIPE = (
    2,
    3,
    4,
    5,
    130,
    141,
)

MEANINGS = {
    0: "fine",
    EXIT_INPUT: "the input cannot be used: a file, a value, an option",
    EXIT_FAILED: "the calculation failed, or something that it needs is missing",
    EXIT_LIMITS: "with --strict: limits are exceeded",
    EXIT_UNDECIDED: "with --strict: whether limits are kept depends on assumed values",
    EXIT_INTERRUPTED: "interrupted",
    EXIT_PIPE: "the program that read the output has ended, as head does",
}
