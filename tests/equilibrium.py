"""Equilibrium of the nodes of a vibrating chain, element by element."""

import numpy as np

from dynamics.response.loads import element_loads


def unbalanced(response, outside):
    """Largest force left on any body of a chain, as a share of the largest k x of its order and speed.

    Parameters
    ----------
    response : ForcedResponse
        Bounded.
    outside : ndarray of shape (K, S, n)
        Forces on the nodes from outside the chain.
    """
    chain, system, loads = response.chain, response.system, element_loads(response)
    w, x = response.angular_frequencies[:, :, np.newaxis], response.motion
    left = outside + w**2 * chain.inertia * x - loads.ground.values
    moved = chain.ground * np.abs(x)
    for place, (first, second) in enumerate(chain.connections):
        force = loads.elements.values[:, :, place]
        spread = chain.distributed_inertia[place] / 6.0
        left[:, :, first] += force
        left[:, :, second] -= force
        for near, far in ((first, second), (second, first)):
            left[:, :, near] += spread * w[..., 0] ** 2 * (2.0 * x[:, :, near] + x[:, :, far])
            moved[:, :, near] += chain.stiffness[place] * np.abs(x[:, :, [first, second]]).sum(
                axis=2
            )
    for place, dashpot in enumerate(chain.dashpots):
        force = loads.dashpots.values[:, :, place]
        left[:, :, dashpot.left] += force
        left[:, :, dashpot.right] -= force
    # Gears join nodes to one body; the rest of the damping is that of its modes.
    ways = chain.expansion()
    modal = system.damping - ways.T @ chain.damping_matrix() @ ways
    body = left @ ways - 1j * w * (response.unknowns @ modal)
    largest = np.max(moved, axis=2)
    return float(np.max(np.max(np.abs(body), axis=2) / np.where(largest > 0.0, largest, 1.0)))
