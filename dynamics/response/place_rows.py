"""Loads and motions of locations per motion of a system's unknowns."""

from collections.abc import Sequence

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from dynamics.indices import index_of_name
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import chain_of

Rows = tuple[FloatArray, tuple[str, ...]]


def load_rows(response: ForcedResponse, elements: Sequence[int | str] | None = None) -> Rows:
    """Return the loads k d of elements, (p, q), and their names; of all elements by default.

    Raises
    ------
    InputError
        If there is no such element, or the response is not that of a chain.
    """
    chain = chain_of(response)
    why = "a load is that of an element"
    chosen = range(len(chain.elements)) if elements is None else elements
    places = [index_of_name("elements", one, chain.elements, "elements", why) for one in chosen]
    rows = chain.stiffness[:, np.newaxis] * chain.elongations() @ response.system.expand
    return rows[places], tuple(chain.elements[place] for place in places)


def motion_rows(response: ForcedResponse, nodes: Sequence[int | str] | None = None) -> Rows:
    """Return the motions of nodes relative to those of the rigid body, (p, q), and their names.

    Raises
    ------
    InputError
        If there is no such node.
    """
    why = "an amplitude is that of a node"
    chosen = range(len(response.names)) if nodes is None else nodes
    places = [index_of_name("node", one, response.names, "nodes", why) for one in chosen]
    system = response.system
    rows = system.expand[places]
    rigid = system.shapes[:, : system.rigid.shape[1]]
    rows = rows - (rows @ rigid) @ (system.mass @ rigid).T
    return rows, tuple(response.names[place] for place in places)


def named_row(response: ForcedResponse, name: str) -> FloatArray:
    """Return the load or the motion of the element or node of a name, (q,).

    Raises
    ------
    InputError
        If the response has no such element or node.
    """
    if response.chain is not None and name in response.chain.elements:
        return np.asarray(load_rows(response, [name])[0][0])
    if name in response.names:
        return np.asarray(motion_rows(response, [name])[0][0])
    raise InputError(
        f"place: given {name!r}; allowed are elements and nodes of the response, because modes tell how "
        "these move."
    )
