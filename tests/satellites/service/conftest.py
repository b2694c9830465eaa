from contextlib import ExitStack

import pytest

pytest.importorskip("fastapi", reason="the service needs crankfem[serve]")
pytest.importorskip("uvicorn")

from satellites.service.serving import THROW, Served, save_model


@pytest.fixture
def serve():
    """Start services that end with the test."""
    with ExitStack() as started:
        yield lambda *options, **bounds: started.enter_context(Served(*options, **bounds))


@pytest.fixture(scope="session")
def models(tmp_path_factory):
    """A folder with one model."""
    folder = tmp_path_factory.mktemp("models")
    save_model(folder)
    return folder


@pytest.fixture(scope="session")
def service(tmp_path_factory, models):
    with Served(tmp_path_factory.mktemp("service"), "--models", str(models)) as served:
        yield served


@pytest.fixture
def throw():
    return dict(THROW)
