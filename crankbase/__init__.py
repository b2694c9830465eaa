"""Common basis of all packages: errors, checks, quantities, tables, drawing style, child processes."""
