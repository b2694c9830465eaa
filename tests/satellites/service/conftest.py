import pytest

pytest.importorskip("fastapi", reason="the service needs crankfem[serve]")
pytest.importorskip("uvicorn")

from satellites.service.serving import models, serve, service, throw  # noqa: F401
