"""What --csv and --pictures refuse, alike in all commands of the mechanism."""

import shutil

import pytest

from crankbase.errors import InputError
from crankfem.files.reading.data_files import data_folder, input_path
from crankfem.jobs.outputs import check_outputs

TABLE = data_folder() / "tables" / "yamz5340_torque_one_throw.csv"
COMMANDS = {
    "mechanism": ("mechanism", input_path("6chn25-34")),
    "harmonics": ("harmonics", input_path("6chn25-34")),
    "harmonics of a table": ("harmonics", TABLE),
    "hinge": ("hinge", input_path("crosshead-30-100", "hinge")),
}


@pytest.mark.parametrize("case", COMMANDS)
def test_an_input_is_never_written_over(call, tmp_path, case):
    command, shipped = COMMANDS[case]
    mine = tmp_path / f"mine{shipped.suffix}"
    shutil.copy(shipped, mine)
    before = mine.read_bytes()
    # Another name of the same file: the names alone do not tell.
    answer = call(command, mine.name, "--csv", tmp_path / "." / mine.name)
    assert (answer.code, answer.out) == (2, "")
    assert "cannot be written, because this command reads that file" in answer.err
    assert mine.read_bytes() == before


@pytest.mark.parametrize("case", COMMANDS)
def test_folders_and_files_are_told_apart(call, tmp_path, case):
    command, shipped = COMMANDS[case]
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    for option, words in (
        (("--csv", "folder"), "--csv folder: cannot be written, because it is a folder"),
        (("--pictures", "file"), "--pictures file: cannot be made a folder, because a file"),
        (("--pictures", "file/in"), "--pictures file/in: cannot be made a folder, because a file"),
        (("--pictures", ""), '--pictures: given ""; allowed is a folder'),
    ):
        answer = call(command, shipped, *option)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith(f"Error: {words}")
        assert answer.err.count("\n") == 1


def test_a_pressure_table_is_an_input_too(call, tmp_path, edit):
    table = tmp_path / "pressure.csv"
    rows = "".join(f"{angle},{5.0 if angle == 0 else 1.0}\n" for angle in range(0, 720, 5))
    table.write_text(f"crank_angle_deg,absolute_pressure_bar\n{rows}", encoding="utf-8")
    text = input_path("6chn25-34").read_text(encoding="utf-8")
    changes = {"[gas]": None}
    mine = tmp_path / "mine.toml"
    mine.write_text(
        edit(text, changes) + '\n[gas]\npressure_table = "pressure.csv"\n', encoding="utf-8"
    )
    before = table.read_bytes()
    for command in ("mechanism", "harmonics"):
        answer = call(command, mine, "--csv", table)
        assert answer.code == 2
        assert "this command reads that file" in answer.err
        assert table.read_bytes() == before


def test_outputs_that_can_be(tmp_path):
    new = tmp_path / "new.csv"
    assert check_outputs(None, None) is None
    assert check_outputs(new, str(tmp_path / "a" / "b"), tmp_path / "in.toml") == tmp_path / "a/b"
    assert list((tmp_path / "a" / "b").iterdir()) == []
    # An older result may be replaced.
    new.touch()
    check_outputs(new, None, tmp_path / "in.toml")


def test_a_folder_that_takes_no_files(monkeypatch, tmp_path):
    def full(**_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.TemporaryFile", full)
    with pytest.raises(InputError, match=r"files cannot be written there, .* No space left"):
        check_outputs(None, str(tmp_path))
