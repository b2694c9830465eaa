"""How far does a six-cylinder's free end twist at each critical speed?"""

import numpy as np

import crankfem as cf

PER_MINUTE = np.pi / 30
chain = cf.load_chain("mwm-six").chain  # with its damping: Mendes et al. 2008
orders = 0.5 * np.arange(1, 25)
firing = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])  # order 1-5-3-6-2-4

# Gas torque of one cylinder from a smooth stand-in for a measured pressure diagram.
angle_deg = np.arange(-360.0, 360.0, 0.5)
angle = np.radians(angle_deg)
swing = np.arcsin(0.0685 / 0.207 * np.sin(angle))
pressure = 90e5 * np.exp(-(((angle_deg - 12.0) / 24.0) ** 2))  # Pa
torque = pressure * np.pi / 4 * 0.105**2 * 0.0685 * np.sin(angle + swing) / np.cos(swing)
phasors = cf.response.phasors_of(cf.harmonics(torque, angles_deg=angle_deg), orders)

speeds = np.linspace(800, 2600, 361) * PER_MINUTE
forces = np.zeros((orders.size, speeds.size, chain.inertia.size), dtype=complex)
forces[:, :, 2:8] = (phasors[:, None] * np.exp(-1j * np.outer(orders, firing)))[:, None, :]
response = cf.forced_response(chain, cf.OrderExcitation(orders, speeds, forces))

twist = response.elastic.synthesis.amplitude[:, 0]  # rad, half peak to peak over the cycle
worst = int(twist.argmax())
print(f"largest twist {1e3 * twist[worst]:.2f} mrad at {speeds[worst] / PER_MINUTE:.0f} 1/min")
for one in sorted(cf.resonances(response, node=0), key=lambda one: -one.severity)[:5]:
    print(
        f"  order {one.order:4g} at {one.speed_rpm:4.0f} 1/min: "
        f"{1e3 * one.amplitude:.2f} mrad, {one.kind}"
    )
print(f"power in less power dissipated: {cf.power_balance(response).error:.0e} of the power in")
