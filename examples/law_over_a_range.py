"""Which web thickness gives a throw of at most 1.5 nm/N, by the law, without a mesh?"""

import numpy as np

import crankfem as cf

thickness = np.linspace(0.050, 0.100, 501)  # m
law = cf.formulas.axial_laws(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=thickness,
    fillet_radius=0.012,
)
low, high = law.band  # 95 % prediction band, m/N

for place in range(0, thickness.size, 100):
    print(
        f"h = {1e3 * thickness[place]:5.1f} mm: e_n = {1e9 * law.pinned[place]:.3f} nm/N "
        f"({1e9 * low[place]:.3f} to {1e9 * high[place]:.3f})"
    )

enough = thickness[high <= 1.5e-9]
print(f"With the whole band below 1.5 nm/N: h >= {1e3 * enough[0]:.1f} mm")
