"""What every package stands on: errors, checks, quantities, tables, drawing style, child processes."""
