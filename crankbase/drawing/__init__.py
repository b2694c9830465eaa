"""What all diagrams share: style, legends, curves over an axis, bars."""
