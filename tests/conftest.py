import pytest


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
