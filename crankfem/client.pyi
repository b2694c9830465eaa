"""Public names of the client and their homes."""

from crankfem.satellites.service.client import Client as Client
from crankfem.satellites.service.client import RefusedError as RefusedError
