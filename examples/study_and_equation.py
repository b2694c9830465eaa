"""Which equation gives e_n over web width and thickness, from nine designs?"""

import tempfile
from pathlib import Path

import crankfem as cf

STUDY = """
[throw]
crank_radius = "170 mm"
main_journal_diameter = "220 mm"
pin_diameter = "180 mm"
main_journal_length = "120 mm"
pin_length = "139 mm"
web_width = "285 mm"
web_thickness = "68 mm"
fillet_radius = "12 mm"

[study]
accuracy = 0.1      # coarse, for a quick look
held_out = 3

[study.factors]
web_width = ["270 mm", "300 mm", "330 mm"]
web_thickness = ["58 mm", "68 mm", "78 mm"]
"""

if __name__ == "__main__":  # worker processes import this file
    folder = Path(tempfile.mkdtemp())
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    result = cf.run_study(folder / "study.toml", folder / "runs.sqlite", workers=2)

    fits = result.fits["axial_compliance"]
    print(fits.chosen)
    found = result.model.lookup("axial_compliance", web_width=0.310, web_thickness=0.064)
    print(f"e_n = {found.value:.3e} {found.unit} ({found.lower:.3e} to {found.upper:.3e})")
