"""Where diagrams may be written."""

import pytest

from crankbase.drawing.diagram_style import figure
from crankbase.errors import InputError


@pytest.mark.parametrize("name", ["picture", "picture.png", "nowhere/picture.svg"])
def test_a_diagram_is_an_svg_file_in_a_folder_that_is_there(tmp_path, name):
    with (
        pytest.raises(InputError, match=r"path: given .*allowed is a file name that ends in \.svg"),
        figure(tmp_path / name),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_the_path_may_be_text(tmp_path):
    with figure(str(tmp_path / "picture.svg")):
        pass
    assert (tmp_path / "picture.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")
