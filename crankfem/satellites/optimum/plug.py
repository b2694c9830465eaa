"""What the core knows of the optimum."""

from crankfem.files.satellites import Plug, UseOfEngines

PLUGS = (
    Plug(
        command=".optimum.command:optimum",
        after="lookup",
        examples=(
            "optimum model.json --minimize web_thickness --limit 'axial_compliance <= 1.2e-9 m/N'",
        ),
        engines=UseOfEngines(used=".optimum.uses:used_sections", case=".optimum.uses:frequencies"),
    ),
)
