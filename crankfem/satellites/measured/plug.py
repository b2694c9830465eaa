"""What the core knows of measured vibration."""

from crankfem.files.satellites import Plug

PLUGS: tuple[Plug, ...] = ()
