"""What do the neighbors of a throw carry when the connecting rod presses on the pin?"""

import numpy as np

import crankfem as cf

throw, material = cf.load_throw("6chn25-34")
analysis = cf.analyze_throw(throw, material, accuracy=0.05)
force = (0.0, -100e3, 20e3)  # N: across the throw, towards the shaft axis, along the shaft

for support in ("pinned", "guided", cf.Neighbors(120.0, 120.0)):
    found = analysis.reactions(pin_force=force, support=support)
    print(f"{support}:")
    for name, end in (("left", found.left), ("right", found.right)):
        forces = ", ".join(f"{1e-3 * value:8.2f}" for value in end.force)
        moments = ", ".join(f"{1e-3 * value:7.3f}" for value in end.moment)
        print(f"  {name:5}  force [{forces}] kN  moment [{moments}] kN m")
    rest = np.add(found.left.force, found.right.force) + force
    print(f"  out of balance by {np.abs(rest).max():.1e} N")
