"""Files that are not TOML say which line is wrong and what to write, to someone who knows no TOML."""

import pytest

from crankbase.errors import InputError
from crankfem.files.reading.toml_file import line_of, place_of, read_toml


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
        ('[a]\nx = "1 mm\n', "line 2, x = .*: given an opening quote without a closing one"),
        ("[a]\nx = '1 mm\n", "line 2, x = .*: given an opening quote without a closing one"),
        ("[a]\nx = \u201c1 mm\u201d\n", "line 2, x = .*: given typographic quotes"),
        (
            '[a]\nx = { value = 0,5, source = "b" }\n',
            "line 2, .*: given 0,5; write a decimal point and no separators, like 0.5",
        ),
        ("[a]\nx = 82,5 mm\n", 'line 2, .*: given 82,5 mm .*"82.5 mm"'),
        ("[a]\nx = 1.200,5 mm\n", 'line 2, .*: given 1.200,5 mm .*"1200.5 mm"'),
        ("[a]\nx = 1,200 mm\n", 'line 2, .*: given 1,200 mm .*"1.2 mm" or "1200 mm", whichever'),
        ("[a]\nx = 1 200 mm\n", 'line 2, .*: given 1 200 mm .*"1200 mm"'),
        ("[a]\nx = 1'200'000 um\n", 'line 2, .*: given 1.200.000 um .*"1200000 um"'),
        ("[a]\nx = [82,5 mm, 9 mm]\n", "line 2, .*: given 82,5 mm in a list .* each quantity"),
        # A list of whole numbers is not at fault for what is wrong after it.
        ("[a]\nx = [1,5,3]]\n", r"line 2, x = \[1,5,3\]\]: is not TOML"),
        ("[a]\nx = [1,5]\ny = '3 mm\n", "line 3, y = .*: given an opening quote"),
        ("[имя]\nx = 1\n", r"line 1, \[имя\]: given a name with other letters than A to Z"),
        ("[a]\nимя = 1\n", "line 2, имя = 1: given a name with other letters than A to Z"),
        ("[a\nx = 1\n", r"line 1, \[a: given a section without its closing bracket"),
        ("[a]\nx: 3\n", "line 2, x: 3: given a colon behind a name; write ="),
        ('[a]\nx = "3 mm",\n', "line 2, .*: given a comma or a semicolon at its end"),
        ("[a]\nx = My Diesel\n", "line 2, .*: given text without quotes; write it in quotes"),
        ("[a]\nx y z\n", r"line 2, x y z: is not TOML \(.*\); allowed is a TOML file"),
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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[a]\nx = " + "1" * 5000, "digits; allowed are numbers of 64 bits"),
        ("[a]\nx = 0x" + "f" * 5000, r"a\.x: given a whole number of 20000 bits"),
        ("[a]\nx = 1e400", r"a\.x: given inf, which is not finite"),
        ("[a]\nx = [1, nan]", r"a\.x\[1\]: given nan, which is not finite"),
        ("[sources]\n" + "".join(f's{n} = "b"\n' for n in range(20_000)), "more than 10000 values"),
        ("a." * 20_000 + "b = 1", "line 1, .*a key of more than 30 names"),
        ("x=1\n[" + "'a' . " * 100_000 + "b]", "line 2, .*a key of more than 30 names"),
        ("[a]\nx = " + "[" * 100 + "]" * 100, "within more than 30 others"),
        ("[a]\nx = " + "[" * 100_000, "within more than 30 others"),
        ('[a]\nx = "' + "a" * 500_000 + '"', r"a\.x: given .* of 500000 characters"),
        ("[a]\n" + "k" * 20_000 + " = 1", "of 20000 characters"),
        ('[a]\nx = "' + "a" * 10**7 + '"', "given a file of 10 MB"),
        ("[" + " " * 200_000, "without its closing bracket"),
    ],
)
def test_what_is_too_long_is_refused_in_a_short_sentence(tmp_path, text, message):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as raised:
        read_toml(path)
    assert len(str(raised.value)) < 500


def test_the_smallest_integer_of_toml_is_read(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f"[a]\nx = {-(2**63)}\n", encoding="utf-8")
    assert read_toml(path).sections["a"]["x"] == -(2**63)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"SQLite format 3\0" + bytes(100), "is the store of a study"),
        (b'\n{"about": 1}', "is a JSON file, such as the results of a run"),
        (b"<!DOCTYPE html>", "is a web page"),
        (b"speed,twist\n1,2\n", r"is a table \(CSV\)"),
        (b"PK\x03\x04", "is a packed file"),
        ("[engine]".encode("utf-16"), "is text in UTF-16; save it as UTF-8"),
        ("# ok\nname = 'Двигатель'".encode("cp1251"), "because line 2 is not UTF-8"),
    ],
)
def test_other_files_are_named(tmp_path, content, said):
    for name in ("mine.toml", "mine.txt"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=said):
            read_toml(tmp_path / name)


def test_the_line_of_a_field_is_found():
    text = '[a]\nx = "1"\n[[a.parts]]\nx = 2\n[[a.parts]]\nx = 3\n[a.inner]\nlist = [1, 2]\n'
    found = {field: line_of(text, field) for field in ("a.x", "a.parts[1].x", "a.inner.list[1]")}
    assert found == {"a.x": 2, "a.parts[1].x": 6, "a.inner.list[1]": 8}
    assert line_of(text, "a.y") is None
    assert place_of(text, "a.y") == "section [a], line 1"
    assert place_of(text, "a.parts[1].y") == "section [a.parts[1]], line 5"
    assert place_of(text, "b.y") is None
    assert line_of(text, "The file") is None
