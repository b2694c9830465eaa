"""What the core knows of crankshafts from CAD."""

from crankfem.files.satellites import Plug

PLUGS = (
    Plug(
        command=".cad.command:cad",
        after="throw",
        examples=(
            "cad crank.step",
            'cad crank.step --free-end high --cut "1=-5 mm" --throws parts',
            "cad crank.step --engine mine.toml",
        ),
    ),
)
