import os

import pytest
from hypothesis import settings

# Matrices are small here: the threads of numpy's and of the solver's library wait for each other, and with
# other processes beside them for much longer than they work. Read when those are first loaded, also by
# children.
for library in ("MKL", "OMP", "OPENBLAS"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# Tests never measure time: an example that takes long on a busy machine is no fault.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items):
    """Let -m 'not slow' leave out the further tests, too."""
    for item in items:
        if item.get_closest_marker("further") is not None:
            item.add_marker("slow")


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
