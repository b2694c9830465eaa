"""The commands, a few in each module; `crankfem.cli` puts them together."""
