from test_crankfem.conftest import _own_folder, call, edit, six_cylinders, told  # noqa: F401
