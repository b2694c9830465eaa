"""What is calculated of a file: each folder has the run, its result and its record."""
