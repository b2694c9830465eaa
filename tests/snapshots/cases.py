"""Command lines whose printed text is kept: of each snapshot its lines, in one folder."""

from satellite_cases import of_satellites
from throws import MEDIUM_SPEED_TOML

# A four-stroke engine in line, one in V with two rods on a pin, and a slow-speed two-stroke one.
ENGINES = ("6chn25-34", "8chn13-14", "6s50mc-c")
THROWS = ("6chn25-34", "12chn18-20", "6s50mc-c")
CHAINS = ("mwm-six", "5rt-flex50d-plant", "container-drive")
IMPERIAL = '--units "in, lbf, ksi"'


def both(line):
    """First screen and all of it."""
    return line, f"{line} --full"


def of_each(lines, names):
    """The same lines for several files."""
    return {
        f"{line.split()[0]}-{name}": both(line.format(name)) for name in names for line in lines
    }


QUICK = {
    **of_each(["check {}"], (*ENGINES, *CHAINS)),
    **of_each(["throw {}"], THROWS),
    **of_each(["harmonics {}"], ENGINES),
    **of_each(["vibration {}"], CHAINS),
    **of_each(["lookup law --throw {}"], THROWS),
    "harmonics-table": (
        *both("harmonics yamz5340_torque_one_throw.csv --firing-order 1-3-4-2"),
        "harmonics yamz5340_torque_one_throw.csv --firing-order 1-2 --full",
        "harmonics yamz5340_torque_one_throw.csv --orders 2",
        "harmonics 6chn25-34 --orders 2",
    ),
    "formulas-published": both("formulas --published"),
    "formulas-without-elements": (
        *both("formulas 6chn25-34 --no-fe --gamma 120"),
        "formulas 6s50mc-c --no-fe --variant printed --full",
    ),
    "plan": (*both("plan 6chn25-34"), "plan yamz-5340", "plan 5rt-flex50d"),
    "two-mass": (
        *both("two-mass yamz-5340"),
        "two-mass yamz-5340 --order 14.5",
        "two-mass yamz-5340 --order 4",
    ),
    "imperial": tuple(
        f"{line} {IMPERIAL}"
        for line in ("throw 6chn25-34", "vibration mwm-six", "harmonics 6chn25-34 --full")
    ),
    "new": (
        "new mine.toml",
        "new mine.toml",
        "new vee.toml --cylinders 12 --strokes 2 --v-angle even",
        "check vee.toml",
        "new copy.toml --from yamz-5340",
        "new --list",
    ),
    "throw-options": (
        "throw 6chn25-34 --pin-force '4, -10, 1 kN' --gamma '90 deg' --full",
        "lookup law --throw 6chn25-34 web_thickness=58mm --full",
        "lookup law --throw 6chn25-34 --gamma '120 deg' --pin-force '100 kN' --full",
    ),
    "fields": ("fields engine", "fields throw", "fields gas", "fields chain"),
}
FURTHER = {
    **of_each(["mechanism {}"], ENGINES),
    **of_each(["stress {}"], THROWS),
    **of_each(["formulas {}"], THROWS),
    **of_each(["vibration {}"], ENGINES),
    **{f"coupled-{name}": both(f"vibration {name} --coupled") for name in ENGINES},
    **of_satellites("SNAPSHOTS"),
    "run-up-and-slopes": (
        'vibration 6chn25-34 --run-up "10 s" --full',
        "vibration 6chn25-34 --slopes",
        "vibration mwm-six --slopes --full",
    ),
    "modes-of-a-throw": ("throw 6chn25-34 --modes 3 --full",),
    "export-and-draw": (
        "export 6chn25-34 a.step",
        "export 6chn25-34 m.vtu --size 2",
        "export 6chn25-34 s.step --shaft",
        "export 6chn25-34 d.inp --calculix --size 2",
        "draw 6chn25-34 --output a.svg",
    ),
    "study": (
        "doe study.toml",
        "doe study.toml --full",
        "verify runs.sqlite",
        "results runs.sqlite runs.csv",
        "fit runs.sqlite --model model.json --full",
        "lookup model.json --throw study.toml",
        "lookup model.json web_width=300mm --gamma 120 --full",
        "lookup model.json web_width=345mm pin_length=139mm",
        "lookup model.json --throw study.toml --gamma -90 --pin-force '0, -100 kN, 0' --full",
        "optimum model.json --minimize web_thickness --limit 'axial_compliance <= 1.2e-9 m/N'",
        "designs study.toml designs",
    ),
}

# The file of the study, whose designs are answered without finite elements.
STUDY = f"""{MEDIUM_SPEED_TOML}
[study]
held_out = 3
[study.factors]
web_width = ["270 mm", "300 mm", "330 mm"]
pin_length = ["120 mm", "139 mm", "158 mm"]
"""
