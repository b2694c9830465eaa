"""How well does a calculated torque agree with a tabulated one, order by order?"""

import numpy as np

import crankfem as cf

table = cf.load_torque_table("yamz5340_torque_one_throw.csv")  # or a file of your own
print(table.source)
given = table.harmonics()

file = cf.load_mechanism("yamz-5340")
torque = cf.engine_torque(file.layout, file.engine.rated_speed, file.pressure)
found = torque.harmonics(1)  # of the first throw

print(f"mean: {given.mean:.1f} N m tabulated, {found.mean:.1f} N m calculated")
for order in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0):
    if order not in given.orders:
        continue
    theirs = given.amplitude[given.index_of(order)]
    ours = found.amplitude[found.index_of(order)]
    print(f"order {order:3g}: {theirs:7.1f} N m tabulated, {ours:7.1f} N m calculated")

four = [0.0, 540.0, 180.0, 360.0]  # deg, firing order 1-3-4-2
orders = np.arange(1, 5)
together = [abs(np.exp(-1j * k * np.radians(four)).sum()) for k in orders]
for order, vectors in zip(orders, together, strict=True):
    print(f"order {order}: the four cylinders' phase vectors add up to {vectors:.1f}")
