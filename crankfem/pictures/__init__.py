"""Pictures: drawings and diagrams written to files; most results draw themselves with `plot()`.

>>> import tempfile
>>> from pathlib import Path
>>> import crankfem as cf
>>> file = cf.load_mechanism("6chn25-34")
>>> with tempfile.TemporaryDirectory() as folder:
...     path = Path(folder) / "balance.svg"
...     cf.pictures.plot_balance(path, cf.balance(file.layout, file.engine.rated_speed))
...     path.exists()
True

`picture_throw` and `picture_shaft` show solids, `picture_stresses` their stresses.
"""

from crankbase.public_names import lazy_exports

__getattr__, __dir__ = lazy_exports(__name__, __file__)
