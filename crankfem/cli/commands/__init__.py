"""The commands, a few in each module; `crankfem.cli.app` puts them together."""
