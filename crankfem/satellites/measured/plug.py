"""What the core knows of measured vibration."""

from crankfem.files.satellites import Plug, UseOfEngines

MEASURED = Plug(
    command=".measured.command:measured",
    after="vibration",
    examples=("measured run.csv --teeth 60-2 --engine cat-3116 --at 'free end'",),
    engines=UseOfEngines(used=".measured.uses:used_by_measured"),
)
CALIBRATE = Plug(
    command=".measured.calibration.command:calibrate",
    after="vibration",
    examples=(
        "calibrate 6chn105-130 run.csv --at 'free end' --move flywheel.inertia=5% --output fitted.toml",
    ),
    engines=UseOfEngines(
        needs=frozenset({"gas", "gas_map"}), used=".measured.uses:used_by_calibrate"
    ),
)
PLUGS: tuple[Plug, ...] = (MEASURED, CALIBRATE)
