"""What the core knows of the elastic hinge."""

from crankfem.files.satellites import FilesOfInput, Plug

PLUGS = (
    Plug(
        command=".hinge.command:hinge",
        after="harmonics",
        examples=("hinge crosshead-30-100 --pictures hinge",),
        files=FilesOfInput(
            kind="hinge",
            about="describes an elastic hinge",
            command="hinge",
            marks=frozenset({"sliding", "hinge", "operation"}),
            reader=".hinge.file:load_hinge",
            sections=".hinge.file:KINDS",
        ),
    ),
)
