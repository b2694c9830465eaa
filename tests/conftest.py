import os

import pytest
from hypothesis import settings

# Dense matrices are small here: the threads of numpy's own library wait for each other, and with other
# processes beside them for much longer than they work. Read when numpy is first loaded, also by children.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Tests never measure time: an example that takes long on a busy machine is no fault.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

# Constants of fem.fillet_stress with which meshes are as coarse as can be.
COARSE_STRESSES = {"BULK": 2.5, "COARSE": 1.0, "COARSEST": 0.5, "FINE": 1.5, "MOST_MESHES": 2}


@pytest.fixture(scope="session")
def coarse_stresses():
    """What to set in fem.fillet_stress where nothing depends on how accurate stresses are."""
    return COARSE_STRESSES


@pytest.fixture(scope="session")
def dimensions():
    """A medium-speed engine's throw, in m."""
    return {
        "crank_radius": 0.170,
        "main_journal_diameter": 0.220,
        "pin_diameter": 0.180,
        "main_journal_length": 0.120,
        "pin_length": 0.139,
        "web_width": 0.300,
        "web_thickness": 0.068,
        "fillet_radius": 0.012,
    }
