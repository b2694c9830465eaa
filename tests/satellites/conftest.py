# Fixtures of tests of commands, which commands of satellites are, too: pytest finds them by name.
from test_crankfem.conftest import (  # noqa: F401
    _own_folder,
    call,
    coarse_throw,
    edit,
    six_cylinders,
    told,
)
