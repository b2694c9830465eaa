"""What of a cross-plane V8's inertia forces remains, without and with counterweights?"""

import math
from dataclasses import replace

import crankfem as cf

rod = cf.ConnectingRod(length=0.15, mass=0.6, center_distance=0.05, inertia=0.002)
bare = cf.EngineLayout(
    crank_radius=0.045,
    cylinders=[
        cf.EngineCylinder(
            0.09, 0.5, rod, crank_angle_deg=crank, bank_angle_deg=bank, position=0.11 * throw
        )
        for throw, crank in enumerate((0, 90, 270, 180))
        for bank in (-45, 45)
    ],
    firing_order=[1, 2, 6, 8, 4, 5, 7, 3],
)
# On each throw: all that turns, and half of what moves to and fro.
weights = cf.balances.balancing_masses(bare, reciprocating_share=0.5)
balanced = replace(bare, rotating=weights)

speed = 6000 * math.pi / 30  # rad/s
for name, layout in (("without counterweights", bare), ("with counterweights", balanced)):
    print(f"{name}:")
    for row in cf.balance(layout, speed, orders=(1, 2, 4)).rows:
        force = "0" if row.force_balanced else f"{1e-3 * row.force.major:.3f} kN"
        moment = "0" if row.moment_balanced else f"{1e-3 * row.moment.major:.3f} kN m"
        print(f"  order {row.order}: force {force}, moment {moment}")
