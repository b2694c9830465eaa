"""The start of the command line: an interrupt is answered in a sentence, even during the imports."""

import sys

# Commands whose finished work is kept and continued.
CONTINUED = ("run", "doe")
EXIT_INTERRUPTED = 130


def interrupted_sentence() -> str:
    """What to say of an interrupt, by the command that was given."""
    if any(word in CONTINUED for word in sys.argv[1:2]):
        return "Stopped. Finished designs are kept; the same command continues where it stopped."
    return "Stopped."


def main() -> None:
    """Run the command line."""
    try:
        from crankfem import cli

        cli.main()
    except KeyboardInterrupt:
        print(interrupted_sentence(), file=sys.stderr)
        raise SystemExit(EXIT_INTERRUPTED) from None
