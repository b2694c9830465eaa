"""What stands apart, each in a folder of its own; `crankfem.files.satellites` names them."""
