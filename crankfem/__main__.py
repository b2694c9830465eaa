"""The command line as ``python -m crankfem``."""

from crankfem.cli.entry import main

if __name__ == "__main__":
    main()
