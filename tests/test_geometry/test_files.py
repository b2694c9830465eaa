"""Which files may be written, and how."""

import json
import os
import re
import sqlite3
import stat
import threading
from pathlib import Path

import meshio
import numpy as np
import pytest

from comparing import close
from crankbase import outputs
from crankbase.errors import InputError
from crankbase.outputs import (
    LISTED,
    atomic_file,
    check_output,
    copy_picture,
    files_listed,
    protected,
    recording_run_files,
    replacing_files,
    write_text,
    write_user_file,
)
from fem.superelement import shaft_compliances
from geometry.crankshaft import Crankshaft, throw_masses
from geometry.imported import import_throw
from geometry.mesh import mesh_throw
from geometry.solid_files import MESH_ENDINGS, write_mesh, write_step
from geometry.throw import CrankThrow
from geometry.throw_dimensions import FurtherPin, Web
from refusals import refused
from regression.law.throw_law import mass_law


@pytest.fixture
def file(tmp_path):
    return tmp_path / "a.csv"


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_that_was_written_gives_way_to_one_of_its_kind(file):
    for text in ("one", "two", "three", "one"):
        write_text(file, text, "table")
        assert file.read_text(encoding="utf-8") == text
    assert names(file.parent) == [LISTED, "a.csv"]


def changed(file):
    write_text(file, "ours", "table")
    file.write_text("mine", encoding="utf-8")


def of_another_kind(file):
    write_text(file, "ours", "picture")


def linked(file):
    (file.parent / "other").write_text("mine", encoding="utf-8")
    file.symlink_to("other")


def linked_to_ours(file):
    write_text(file.with_name("b.csv"), "ours", "table")
    file.symlink_to("b.csv")


def leading_nowhere(file):
    file.symlink_to("nowhere")


def renamed(file):
    write_text(file.with_name("b.csv"), "ours", "table")
    file.with_name("b.csv").rename(file)


def with_a_list_that_is_none(file):
    write_text(file, "ours", "table")
    file.with_name(LISTED).write_text('{"format": "crankfem outputs", "files": 3}')


def with_a_list_that_is_a_link(file):
    write_text(file, "ours", "table")
    file.with_name(LISTED).rename(file.with_name("list"))
    file.with_name(LISTED).symlink_to("list")


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda file: file.write_text("mine", encoding="utf-8"), "crankfem has not made it"),
        (changed, "it was changed since crankfem wrote it"),
        (of_another_kind, "it is a picture and no table"),
        (linked, "it is a link"),
        (linked_to_ours, "it is a link"),
        (leading_nowhere, "it is a link"),
        (renamed, "crankfem has not made it"),
        (with_a_list_that_is_none, "crankfem has not made it"),
        (with_a_list_that_is_a_link, "crankfem has not made it"),
    ],
)
def test_a_file_of_the_users_stays_unless_forced(file, make, reason):
    make(file)
    before = {path: path.read_bytes() for path in file.parent.iterdir() if path.exists()}
    with pytest.raises(InputError) as caught:
        write_text(file, "new", "table")
    assert str(caught.value).startswith(f"{file}: is not replaced, because {reason}")
    assert "--force" in str(caught.value)
    assert {path: path.read_bytes() for path in file.parent.iterdir() if path.exists()} == before
    with replacing_files():
        write_text(file, "new", "table")
    assert not file.is_symlink()
    assert file.read_text(encoding="utf-8") == "new"
    # What a link led to stays what it was.
    others = {path: content for path, content in before.items() if path.name in ("other", "b.csv")}
    assert {path: path.read_bytes() for path in others} == others
    write_text(file, "newer", "table")


def test_an_empty_file_has_nothing_to_lose(file):
    file.touch()
    write_text(file, "new", "table")


def test_what_an_earlier_release_wrote_is_known_by_its_content(file):
    def recognized(path):
        return path.read_text(encoding="utf-8").startswith("ours")

    file.write_text("ours, long ago", encoding="utf-8")
    write_text(file, "new", "model", recognized=recognized)
    file.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="it is not an unchanged model made by crankfem"):
        write_text(file, "new", "model", recognized=recognized)


@pytest.mark.parametrize("link", [os.link, os.symlink, None])
def test_an_input_is_never_replaced(file, tmp_path, link):
    read = tmp_path / "read.csv" if link else file
    read.write_text("mine", encoding="utf-8")
    if link:
        link(read, file)
    reason = "because this command reads that file"
    with replacing_files(), protected(read), pytest.raises(InputError, match=reason):
        write_text(file, "new", "table")
    assert read.read_text(encoding="utf-8") == "mine"


def test_a_store_is_never_replaced(file):
    connection = sqlite3.connect(file)
    connection.execute("CREATE TABLE a (b)")
    connection.close()
    before = file.read_bytes()
    with replacing_files(), pytest.raises(InputError, match="because it is a database"):
        write_text(file, "new", "table")
    assert file.read_bytes() == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anything")
def test_a_file_that_may_not_be_changed_stays(file):
    write_text(file, "old", "table")
    file.chmod(0o444)
    with pytest.raises(InputError, match="may not be changed"):
        write_text(file, "new", "table")


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(InputError, match="because it is a folder"):
        check_output(tmp_path, "table")


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_rights_are_those_of_any_new_file(file, mask):
    before = os.umask(mask)
    try:
        write_text(file, "new", "table")
    finally:
        os.umask(before)
    assert stat.S_IMODE(file.stat().st_mode) == 0o666 & ~mask


def test_a_name_that_can_be_foretold_leads_nowhere(file, tmp_path):
    """Somebody who knows the name of the unfinished file could lay a link in its place."""
    (tmp_path / "victim").write_text("mine", encoding="utf-8")
    for name in ("a.csv.part", ".a.csv.part", ".a.csv", "a.csv.tmp"):
        (tmp_path / name).symlink_to("victim")
    seen = []
    for _ in range(2):
        with atomic_file(file, "table") as part:
            seen.append(part.name)
            assert part.parent == file.parent
            assert part.suffix == file.suffix
            part.write_text("new", encoding="utf-8")
    assert len(set(seen)) == 2
    assert (tmp_path / "victim").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_what_fails_leaves_what_was_there(file, error):
    write_text(file, "old", "table")

    def write():
        with atomic_file(file, "table") as part:
            part.write_text("half", encoding="utf-8")
            raise error

    with pytest.raises(type(error)) as caught:
        write()
    if isinstance(error, OSError):
        assert caught.value.filename == str(file)
    assert file.read_text(encoding="utf-8") == "old"
    assert names(file.parent) == [LISTED, "a.csv"]


def test_an_error_names_the_file_and_not_its_part(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        write_text(tmp_path / "nowhere" / "a.csv", "new", "table")
    assert caught.value.filename == str(tmp_path / "nowhere" / "a.csv")


@pytest.mark.parametrize("step", ["before", "after"])
def test_a_program_that_dies_leaves_a_file_that_the_next_one_knows(file, monkeypatch, step):
    """Its list stands before the file: whichever of the two files is there, it is listed."""
    write_text(file, "old", "table")
    replace = os.replace

    def die(source, target):
        if step == "after" or os.fspath(target).endswith(LISTED):
            replace(source, target)
        if not os.fspath(target).endswith(LISTED):
            raise SystemExit

    with monkeypatch.context() as patch:
        patch.setattr(outputs.os, "replace", die)
        with pytest.raises(SystemExit):
            write_text(file, "new", "table")
    assert file.read_text(encoding="utf-8") == ("old" if step == "before" else "new")
    write_text(file, "newer", "table")


def test_a_file_put_there_meanwhile_stays(file):
    def write():
        with atomic_file(file, "table") as part:
            part.write_text("new", encoding="utf-8")
            file.write_text("mine", encoding="utf-8")

    with pytest.raises(InputError, match="crankfem has not made it"):
        write()
    assert file.read_text(encoding="utf-8") == "mine"


def test_a_pipe_takes_what_it_is_given(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_text(encoding="utf-8")))
    reader.start()
    write_text(pipe, "new", "table")
    reader.join(timeout=10.0)
    assert got == ["new"]
    assert names(tmp_path) == ["pipe"]


def test_a_list_names_nothing_outside_its_folder(tmp_path):
    (tmp_path / "in").mkdir()
    with recording_run_files():
        write_text(tmp_path / "a", "ours", "table")
        write_text(tmp_path / "in" / "a", "ours", "table")
    listed = json.loads((tmp_path / "in" / LISTED).read_text(encoding="utf-8"))
    entry = listed["files"]["a"]
    for name in ("../a", "..", "", str(tmp_path / "a")):
        listed["files"][name] = entry
    (tmp_path / "in" / LISTED).write_text(json.dumps(listed), encoding="utf-8")
    assert files_listed(tmp_path / "in") == [tmp_path / "in" / "a"]


def test_only_a_run_takes_a_runs_place(file):
    write_text(file, "of a command", "table")
    with recording_run_files(), pytest.raises(InputError, match="no run of crankfem has made it"):
        write_text(file, "of a run", "table")
    assert files_listed(file.parent) == []


def test_what_is_handed_over_is_the_users(file):
    write_user_file(file, b"a template")
    assert names(file.parent) == ["a.csv"]
    with pytest.raises(InputError, match="crankfem has not made it"):
        write_user_file(file, b"another")


def test_a_copy_is_written_like_any_file(file, tmp_path):
    (tmp_path / "from").write_bytes(b"\x00\xff")
    copy_picture(tmp_path / "from", file)
    assert file.read_bytes() == b"\x00\xff"


@pytest.fixture(scope="module")
def mesh(dimensions):
    return mesh_throw(CrankThrow(**dimensions, pin_bore=0.06), 2.0, "full")


# What Abaqus' keywords manual allows: 20 characters in a number, 16 entries and 256 characters in a line,
# names of up to 80 characters that begin with a letter.
def test_an_inp_file_keeps_the_published_card_format(mesh, tmp_path):
    lines = write_mesh(mesh, tmp_path / "throw.inp").read_text(encoding="ascii").splitlines()
    data = [line.split(",") for line in lines if not line.startswith("*")]
    assert max(map(len, lines)) <= 256
    assert max(map(len, data)) <= 16
    assert max(len(entry) for row in data for entry in row) <= 20
    cards = [line for line in lines if line.startswith("*") and not line.startswith("**")]
    keywords = ["*NODE", "*ELEMENT", *["*NSET", "*SURFACE"] * len(mesh.surfaces)]
    assert [card.partition(",")[0] for card in cards] == keywords
    assert cards[:2] == ["*NODE, NSET=MESH", "*ELEMENT, TYPE=C3D10, ELSET=THROW"]
    names = [card.split("=")[1].partition(",")[0] for card in cards[2::2]]
    assert names == [name.upper().replace(" ", "_") for name in mesh.surfaces]
    assert all(re.fullmatch("[A-Z][A-Z0-9_]{,79}", name) for name in names)


def test_faces_of_elements_are_numbered_as_in_the_manual(mesh, tmp_path):
    """Faces S1 to S4 of C3D10 by Abaqus: corners 1 2 3, 1 4 2, 2 4 3, 3 4 1."""
    text = write_mesh(mesh, tmp_path / "throw.inp").read_text(encoding="ascii")
    block = text.partition("*SURFACE, NAME=RIGHT_END, TYPE=ELEMENT\n")[2].partition("*")[0]
    rows = np.array([row.split(",S") for row in block.split()], dtype=int) - 1
    faces = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    corners = mesh.elements[rows[:, [0]], faces[rows[:, 1]]]
    assert np.array_equal(np.sort(corners), np.sort(mesh.surfaces["right end"]))


@pytest.mark.slow
def test_values_at_nodes_travel(mesh, tmp_path):
    values = {"displacement": mesh.points * 2.0}
    read = meshio.read(write_mesh(mesh, tmp_path / "throw.vtu", values))
    assert read.point_data["displacement"] == close(mesh.points * 2.0)
    with refused("point_data"):
        write_mesh(mesh, tmp_path / "throw.msh", values)
    with refused("point_data['short']"):
        write_mesh(mesh, tmp_path / "throw.vtu", {"short": np.zeros(3)})


def test_unknown_endings_and_missing_folders(mesh, tmp_path):
    for ending in (".bdf", ".vtk", ".ply", ".obj"):
        with refused(f"throw{ending}"):
            write_mesh(mesh, tmp_path / f"throw{ending}")
    for name, given in (("mesh", (3, "throw.inp")), ("path", (mesh, 3))):
        with refused(name):
            write_mesh(*given)
    for ending in MESH_ENDINGS:
        with pytest.raises(InputError, match="cannot be written"):
            write_mesh(mesh, tmp_path / "nowhere" / f"throw{ending}")


@pytest.mark.parametrize(
    "changes",
    [
        {"pin_bore": 0.06},
        {"fillet_radius": 0.0, "pin_diameter": 0.22},
        {"further_pins": (FurtherPin(angle=0.6, web_thickness=0.0),)},
        {"further_pins": (FurtherPin(angle=np.pi),)},
    ],
)
def test_a_written_throw_is_read_by_its_names(dimensions, tmp_path, changes):
    throw = CrankThrow(**{**dimensions, **changes})
    path = write_step(throw, tmp_path / "throw.step")
    names = [pin.name for pin in throw.parts.pins]
    read = import_throw(path)
    assert read.remarks == ()
    assert read.volume == close(throw.volume, rel=1e-6)
    assert read.length == close(throw.length, rel=1e-9)
    assert np.array(read.pin_axes) == close(np.array(throw.pin_axes), abs=1e-9)
    assert [pin.name for pin in read.pins] == names


def test_step_errors(dimensions, tmp_path):
    throw = CrankThrow(**dimensions)
    lopsided = CrankThrow(**dimensions, right_web=Web(thickness=0.05))
    for field, part, *given in (
        ("part", lopsided, tmp_path / "throw.step", "quarter"),
        ("part", throw, tmp_path / "throw.step", "third"),
        ("throw.iges", throw, tmp_path / "throw.iges"),
    ):
        with refused(field):
            write_step(part, *given)
    with pytest.raises(InputError, match="cannot be written"):
        write_step(throw, tmp_path / "nowhere" / "throw.step")


@pytest.mark.parametrize(
    ("field", "door"),
    [
        ("solid", lambda throw: write_step(throw, "throw.step")),
        ("throw", lambda throw: throw_masses(throw, 7850.0)),
        ("throw", mass_law),
        ("throws[0]", lambda throw: Crankshaft([throw], crank_angles_deg=[0.0])),
        ("throws[0]", lambda throw: shaft_compliances([throw], crank_angles_deg=[0.0])),
        ("mesh", lambda throw: write_mesh(throw, "throw.msh")),
    ],
)
def test_a_throw_of_another_kind_is_refused_by_name(field, door):
    with refused(field):
        door(Path("throw.step"))
