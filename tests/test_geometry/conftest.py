import pytest

from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow


@pytest.fixture(scope="session")
def coarse_mesh(dimensions):
    return mesh_throw(CrankThrow(**dimensions), 2.0)
