"""Which viscous damper keeps a four-cylinder's torsional stress below 30 MPa?"""

import numpy as np

import crankfem as cf

PER_MINUTE = np.pi / 30
file = cf.load_mechanism("yamz-5340")
engine = cf.torsional_chain(
    [5.63e-7] * 4,  # rad/(N m), each throw
    [0.0374] * 4,  # kg m^2, with rods and pistons
    flywheel_inertia=0.78,
    free_end_inertia=0.01,
)
speeds = np.linspace(600, 2300, 171) * PER_MINUTE
forces = cf.excitation.cylinder_forces(file.layout, speeds, 12.0, file.pressure)
excitation = cf.excitation.torque_excitation(forces, engine)

modulus = float(cf.response.section_modulus("torsional", 0.070))  # m^3, a journal of 70 mm
stress = cf.limits.element_load(excitation, 3, section=modulus, magnifier=40)
limit = cf.limits.given_limit(
    "torsional stress", 30e6, "Pa", applies_to="crankshaft", source="an example"
)
rule = cf.limits.BarredRangeRule(2300 * PER_MINUTE)
bare = stress(engine.chain)
print(f"without a damper: {bare.values.max() / 1e6:.1f} MPa")
print(cf.judge([(limit, bare)], (speeds[0], speeds[-1]), rule).sentence)

sized = cf.dampers.size_viscous_damper(
    engine.chain, "free end", stress, limit, ring_inertia=(0.002, 0.1)
)
print(sized.sentence)
print(cf.judge([(limit, sized.curve)], (speeds[0], speeds[-1]), rule).sentence)
