"""What the core's tests of every command and file do with crankshafts from CAD."""

# Of a command that reads files: a line of it. Its JSON is looked at here.
READS = {"cad": ("cad", "PATH", "--no-fe")}
