"""Reading of files: TOML with units and sources, shipped files, kinds of files, tables."""
