"""What the core knows of the service."""

from crankfem.files.satellites import Plug

PLUGS = (
    Plug(
        command=".service.command:serve",
        after="report",
        examples=("serve", "serve --models models --port 8000"),
    ),
)
