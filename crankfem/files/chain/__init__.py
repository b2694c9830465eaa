"""Chain files: nodes and elements in TOML or plain text."""
