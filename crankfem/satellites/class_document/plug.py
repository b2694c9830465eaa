"""What the core knows of the class document."""

from crankfem.files.satellites import Plug, UseOfEngines

PLUGS = (
    Plug(
        command=".class_document.command:class_",
        after="vibration",
        examples=("class 5rt-flex50d --output submission",),
        engines=UseOfEngines(
            needs=frozenset({"gas", "gas_map"}), used=".class_document.uses:used_sections"
        ),
    ),
)
