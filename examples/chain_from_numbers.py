"""Natural frequencies and critical speeds of a torsional chain: what do inertias and stiffnesses give?"""

import crankfem as cf

# The MWM six-cylinder diesel of Mendes et al. 2008: pulley, gears, six cylinders, flywheel.
chain = cf.Chain(
    inertia=[0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750],  # kg m^2
    stiffness=[1.106e6, 1.631e6, 1.253e6, 1.253e6, 1.678e6, 1.253e6, 1.253e6, 1.976e6],  # N m/rad
    names=["pulley", "gears", *(f"cylinder {k}" for k in range(1, 7)), "flywheel"],
)
modes = chain.modes()
for mode in range(modes.rigid, 4):
    frequency = modes.frequencies[mode]
    strain = modes.strain_shares[:, mode]
    softest = modes.strain_names[strain.argmax()]
    nodes = ", ".join(f"{place:.2f}" for place in modes.node_positions[mode])
    print(
        f"{frequency:6.1f} Hz: nodes at {nodes}; most strain energy in {softest} ({max(strain):.0%})"
    )
    for order in (3, 6):
        print(f"  order {order} is critical at {60 * frequency / order:5.0f} 1/min")
