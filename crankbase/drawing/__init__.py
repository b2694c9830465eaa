"""Common parts of diagrams: style, legends, curves over an axis, bars."""
