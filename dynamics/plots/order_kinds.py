"""Colors of major and minor orders, the same in stars and Campbell diagrams."""

from geometry.diagram_style import GRAY, ORANGE, RED

KIND_COLORS = {"major": RED, "minor": ORANGE, "balanced": GRAY}
