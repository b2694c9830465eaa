#!/usr/bin/env bash
# scikit-fem 12.0.2: a load behind a multipoint constraint does not pass it.
# Expected: mpc(A, b, S, M) is the constraint x[S] = T x[M] of mechanics: T' A T and T' b, so that forces pass.
# What happens: the rows of S are left out instead of added to those of M: the system is not symmetric, the part behind the
# joint follows the part before it and pulls with nothing, and no warning says so. Right for a one-sided follower only.
# Three springs in a row, ground - 0 - 1, joint 1 = 2, 2 - 3, stiffness 1, and a force of 1 at node 3:
# Output seen:
#   displacements [0. 0. 0. 1.], expected [1. 2. 2. 3.]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q scikit-fem==12.0.2 numpy==2.4.6 scipy==1.17.1
venv/bin/python - <<'PY'
import sys

import numpy as np
from scipy.sparse import csr_matrix
from skfem import mpc, solve

stiffness = csr_matrix(np.array([[2.0, -1, 0, 0], [-1, 1, 0, 0], [0, 0, 1, -1], [0, 0, -1, 1]]))
force = np.array([0.0, 0, 0, 1])
got = solve(*mpc(stiffness, force, S=np.array([2]), M=np.array([1])))
joined = np.array([[1.0, 0, 0], [0, 1, 0], [0, 1, 0], [0, 0, 1]])
right = joined @ np.linalg.solve(joined.T @ stiffness.toarray() @ joined, joined.T @ force)
print(f"displacements {got}, expected {right}")
sys.exit(0 if np.allclose(got, [0, 0, 0, 1]) and np.allclose(right, [1, 2, 2, 3]) else "changed")
PY
