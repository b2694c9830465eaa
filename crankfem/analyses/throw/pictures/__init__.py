"""Drawings and rendered pictures of a throw or a crankshaft."""
