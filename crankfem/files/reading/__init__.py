"""Files as such: TOML with units and sources, shipped files, kinds of files, tables."""
