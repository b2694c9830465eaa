"""Files that are not TOML say which line is wrong and what to write, to someone who knows no TOML."""

import pytest

from crankbase.errors import InputError
from crankfem.files.reading.toml_file import read_toml


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[throw]\nweb_width = 9 in\n", 'line 2, web_width = 9 in: given 9 in without.*"9 in"'),
        (
            '[piston]\nmass = { value = 17 kg, source = "5 in a row" }\n',
            'line 2, .*: given 17 kg without quotes.*"17 kg"',
        ),
        ('[engine]\nangles = ["0 deg", 120 deg]\n', '"120 deg"'),
        (
            '[a]\nx = 1\n\n[b]\nx = 1\ny = 2\nx = "3 mm"\n',
            r'line 7, x = "3 mm": given twice, in line 5',
        ),
        ("[a]\nx = 1\n[b]\n[a]\n", r"line 4, \[a\]: given twice, in line 1"),
        ('[a]\nx = "1 mm\n', r"line 2, x = .*: is not TOML \(.*\); allowed is a TOML file"),
    ],
)
def test_what_is_no_toml_is_told_with_its_line(tmp_path, text, message):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as raised:
        read_toml(path)
    assert "(at line" not in str(raised.value)


def test_misspelled_section_is_told(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[rood]\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"\[rood\] is an unknown section; did you mean \[rod\]\?"):
        read_toml(path).check_sections({"rod": False, "piston": False})
