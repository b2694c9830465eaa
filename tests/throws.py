"""The throw that most tests start from: that of a medium-speed engine, in m."""

MEDIUM_SPEED = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "web_width": 0.285,
    "web_thickness": 0.068,
    "fillet_radius": 0.012,
}

# The same, as a file says it, without fillets.
MEDIUM_SPEED_TOML = """[throw]
crank_radius = "170 mm"
main_journal_diameter = "220 mm"
pin_diameter = "180 mm"
main_journal_length = "120 mm"
pin_length = "139 mm"
web_width = "285 mm"
web_thickness = "68 mm"
"""
