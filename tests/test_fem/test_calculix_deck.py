"""The deck for CalculiX as text, its results as text, and what goes wrong with the program."""

import re
from dataclasses import replace

import numpy as np
import pytest

from calculix_run import CalculixError, read_calculix, run_calculix
from crankbase.errors import InputError, MissingLibraryError
from fem.calculix import (
    LoadCase,
    axial_case,
    bending_case,
    calculix_deck,
    pin_case,
    standard_cases,
    torque_case,
    write_calculix,
)
from fem.material import STEEL
from fem.superelement import nodes_on
from geometry.solid import LEFT_END, RIGHT_END
from refusals import refusals, refused

RADIAL = [[0.0, -1.0, 0.0]]
CASES = (
    axial_case("pinned"),
    bending_case("y"),
    pin_case([[2.0, -3.0, 0.5]], "guided", blocked=True),
)
# Two steps as ccx 2.20 prints them, and a table of another set between.
PRINTED = """
 displacements (vx,vy,vz) for set ENDS and time  0.1000000E+01

      4448  0.000000E+00  0.000000E+00  0.000000E+00
      4449  4.776175E-06  1.302990E-09  0.000000E+00
      4450  0.000000E+00  0.000000E+00  1.199002E-06
      4451 -4.784483E-06 -7.441510E-10  3.551075E-09

 displacements (vx,vy,vz) for set PIN and time  0.1000000E+01

        17  1.000000E+00  1.000000E+00  1.000000E+00

 forces (fx,fy,fz) for set ENDS and time  0.1000000E+01

      4448  1.266809E-11 -4.767831E-11 -1.000000E+03
      4449  4.222449E-12  2.174261E-12  5.170309E-13
      4450 -1.553913E-11  1.353655E-10  1.000000E+03
      4451 -6.601220E-12 -2.851053E-13  1.409151E-13

 displacements (vx,vy,vz) for set ENDS and time  0.2000000E+01

      4448  0.000000E+00  0.000000E+00  0.000000E+00
      4449  2.147121E-08 -1.219832E-05  0.000000E+00
      4450  0.000000E+00  0.000000E+00  3.551075E-09
      4451 -1.834389E-08 -1.219309E-05  3.904654E-05

 forces (fx,fy,fz) for set ENDS and time  0.2000000E+01

      4448 -7.021157E-10  8.719780E-11 -7.685408E-11
      4449 -5.273365E-12  6.161571E-12 -1.000000E+03
      4450 -6.677396E-10  2.665246E-10  6.260414E-11
      4451  1.810024E-12  1.579037E-11  1.000000E+03
"""


@pytest.fixture(scope="module")
def deck(full_mesh):
    return calculix_deck(full_mesh, STEEL, CASES)


def cards(deck):
    """The deck without comments: (keyword line, rows of fields) one after the other."""
    found = []
    for line in deck.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            found.append((line, []))
        else:
            found[-1][1].append(line.split(","))
    return found


def rows(deck, start):
    return next(rows for card, rows in cards(deck) if card.startswith(start))


def steps(deck):
    """Held motions and loads of each step: (node, axis) pairs, and {(node, axis): load}."""
    found = []
    for card, fields in cards(deck):
        if card.startswith("*STEP"):
            found.append([set(), {}])
        elif card.startswith("*BOUNDARY"):
            assert card.endswith("OP=NEW")
            assert all(first == last for _, first, last in fields)
            found[-1][0] = {(int(node), int(axis)) for node, axis, _ in fields}
        elif card.startswith("*CLOAD"):
            assert card.endswith("OP=NEW")
            found[-1][1] = {(int(node), int(axis)): float(load) for node, axis, load in fields}
            assert len(found[-1][1]) == len(fields)
    return found


@pytest.mark.slow
def test_every_number_fits_into_a_field_and_keeps_its_digits(full_mesh, deck):
    for card, fields in cards(deck):
        for row in fields:
            assert len(row) <= 16, card
            assert all(0 < len(field) <= 20 for field in row), card
    read = np.array([[float(field) for field in row[1:]] for row in rows(deck, "*NODE, NSET=MESH")])
    assert len(read) == len(full_mesh.points)
    # Longer numbers than fit are cut after 13 digits.
    np.testing.assert_allclose(read, full_mesh.points, rtol=1e-12, atol=0.0)
    assert deck.isascii()


def test_edge_nodes_stand_where_c3d10_wants_them(deck):
    """CalculiX's figure of C3D10: nodes 5 to 10 on the edges 12 23 13 14 24 34."""
    points = {int(row[0]): np.array(row[1:], dtype=float) for row in rows(deck, "*NODE, NSET=MESH")}
    elements = np.array(rows(deck, "*ELEMENT"), dtype=int)
    assert elements[:, 0].tolist() == list(range(1, len(elements) + 1))
    corners = np.array([[points[node] for node in nodes[1:]] for nodes in elements])
    edges = np.array([(1, 2), (2, 3), (1, 3), (1, 4), (2, 4), (3, 4)]) - 1
    middles = 0.5 * (corners[:, edges[:, 0]] + corners[:, edges[:, 1]])
    distances = np.linalg.norm(corners[:, 4:, None] - middles[:, None], axis=3)
    assert np.array_equal(
        distances.argmin(axis=2), np.broadcast_to(np.arange(6), distances.shape[:2])
    )
    # Corners turn the way that gives a positive volume.
    assert np.all(np.linalg.det(corners[:, 1:4] - corners[:, :1]) > 0.0)


@pytest.mark.parametrize("surface", [LEFT_END, RIGHT_END])
def test_end_sections_are_rigid_with_corner_and_edge_nodes(full_mesh, deck, surface):
    name = surface.upper().replace(" ", "_")
    section = {int(node) for row in rows(deck, f"*NSET, NSET={name}") for node in row}
    assert section == set((nodes_on(full_mesh, surface) + 1).tolist())
    assert set((np.unique(full_mesh.surfaces[surface]) + 1).tolist()) < section
    center, rotation = (1, 2) if surface == LEFT_END else (3, 4)
    count = len(full_mesh.points)
    card = f"*RIGID BODY, NSET={name}, REF NODE={count + center}, ROT NODE={count + rotation}"
    assert card in deck.splitlines()
    places = {
        int(row[0]): [float(field) for field in row[1:]] for row in rows(deck, "*NODE, NSET=ENDS")
    }
    assert places[count + center] == [0.0, 0.0, full_mesh.length * (surface == RIGHT_END)]


def test_supports(full_mesh, deck):
    left, left_turn, right, right_turn = range(len(full_mesh.points) + 1, len(full_mesh.points) + 5)
    pinned = {(left, 1), (left, 2), (left, 3), (left_turn, 3), (right, 1), (right, 2)}
    tilts = {(left_turn, 1), (left_turn, 2), (right_turn, 1), (right_turn, 2)}
    held = [held for held, _ in steps(deck)]
    assert held == [pinned, pinned, pinned | tilts | {(right, 3)}]


def test_loads(full_mesh, deck):
    count = len(full_mesh.points)
    axial, bending, pin = (loads for _, loads in steps(deck))
    assert axial == {(count + 3, 3): 1.0}
    assert bending == {(count + 2, 2): -1.0, (count + 4, 2): 1.0}
    total = np.zeros(3)
    moment = np.zeros(3)
    for (node, axis), load in pin.items():
        force = load * np.eye(3)[axis - 1]
        total += force
        moment += np.cross(full_mesh.points[node - 1], force)
    np.testing.assert_allclose(total, [2.0, -3.0, 0.5], rtol=1e-12)
    # The uniform force acts at the middle of the pin; its coarse mesh moves that by 1e-6 m.
    place = [0.0, 0.170, 0.5 * full_mesh.length]
    np.testing.assert_allclose(moment, np.cross(place, [2.0, -3.0, 0.5]), atol=1e-5)
    loaded = {int(node) for row in rows(deck, "*NSET, NSET=PIN") for node in row}
    assert {node for node, _ in pin} == loaded


def test_a_title_stays_in_its_comment(full_mesh):
    case = LoadCase("two\n*CLOAD\nlines", end_loads=axial_case().end_loads)
    text = calculix_deck(full_mesh, STEEL, [case])
    assert "** Step 1: two *CLOAD lines" in text.splitlines()
    assert text.count("\n*CLOAD") == 1


def test_standard_cases_hold_every_question(full_mesh):
    cases = standard_cases(full_mesh)
    assert {axial_case("guided"), torque_case(), bending_case("x")} < set(cases)
    assert pin_case([[0, 1, 0]], "guided", blocked=True) in cases
    assert len(cases) == len(set(cases)) == 6 + 2 * 2 * 3


@pytest.mark.parametrize(
    "text",
    [
        "",
        PRINTED.split(" forces")[0],
        PRINTED.replace("1.199002E-06", "NaN"),
        PRINTED.replace("1.199002E-06", "**************"),
        re.sub(" *4451.*\n", "", PRINTED),
    ],
    ids=["empty", "no forces", "not a number", "overflow", "three nodes"],
)
def test_unreadable_results(tmp_path, text):
    path = tmp_path / "throw.dat"
    path.write_text(text)
    with pytest.raises(CalculixError, match=r"throw\.dat"):
        read_calculix(path)


def test_missing_results(tmp_path):
    with pytest.raises(CalculixError, match="cannot be read"):
        read_calculix(tmp_path / "none.dat")


def test_only_a_whole_throw(mesh, half_mesh, tmp_path):
    for part in (mesh, half_mesh):
        with refused("mesh.part"):
            write_calculix(part, STEEL, tmp_path / "throw.inp")
    assert not list(tmp_path.iterdir())


def test_bad_input(full_mesh, tmp_path):
    with refused("throw.txt"):
        write_calculix(full_mesh, STEEL, tmp_path / "throw.txt")
    with pytest.raises(InputError, match="cannot be written"):
        write_calculix(full_mesh, STEEL, tmp_path / "none" / "throw.inp", CASES)
    with refused("material"):
        calculix_deck(full_mesh, None, CASES)
    with refused("cases"):
        calculix_deck(full_mesh, STEEL, [])
    for field, given in (
        ("mesh", ("throw", STEEL, "a.inp")),
        ("path", (full_mesh, STEEL, 3)),
        ("cases", (full_mesh, STEEL, "a.inp", "axial")),
        ("cases[1]", (full_mesh, STEEL, "a.inp", [axial_case(), "axial"])),
    ):
        with refused(field):
            write_calculix(*given)
    with pytest.raises(InputError, match="2 pins"):
        calculix_deck(full_mesh, STEEL, [pin_case(2 * RADIAL, blocked=True)])


@pytest.fixture
def program(tmp_path):
    """Make a program that does something in place of CalculiX, and a deck for it."""
    deck = tmp_path / "my throw.inp"
    deck.write_text("** nothing\n")

    def make(script):
        path = tmp_path / "ccx_script"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        return deck, str(path)

    return make


def test_run_in_the_folder_of_the_deck(program):
    deck, path = program('echo "$@ $OMP_NUM_THREADS" > "$2.dat"; echo Job finished')
    results = run_calculix(deck, threads=3, program=path)
    assert results == deck.with_suffix(".dat")
    assert results.read_text() == "-i my throw 3\n"


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("echo ' *ERROR reading *NODE. Card:'; echo '   70,x'; exit 201", r"201 .*\*NODE.*70,x"),
        ("echo ' *ERROR in e_c3d: nonpositive jacobian'", "nonpositive jacobian"),
        ("echo Job finished", "ended with code 0"),
        ("kill -SEGV $$", "ended with code -11"),
        ("exec sleep 5", "took more than 0.2 s"),
    ],
)
def test_failing_runs(program, script, reason):
    deck, path = program(script)
    old = deck.with_suffix(".dat")
    old.write_text(PRINTED)
    with pytest.raises(CalculixError, match=reason):
        run_calculix(deck, time_limit=0.2 if "sleep" in script else 60.0, program=path)
    assert not old.exists()  # what an earlier run left is not taken for results


def test_missing_program_and_deck(program, tmp_path):
    deck, _ = program("")
    with pytest.raises(MissingLibraryError, match="apt-get install calculix-ccx"):
        run_calculix(deck, program="no-such-ccx")
    with refused("deck"):
        run_calculix(tmp_path / "none.inp")


test_refused = refusals(
    ("support", lambda: axial_case("clamped")),
    ("axis", lambda: bending_case("z")),
    ("load case 'short'", lambda: LoadCase("short", end_loads=(1.0,))),
    ("load case 'flat'", lambda: LoadCase("flat", pin_forces=((1.0, 2.0),))),
    (
        "load case 'pin forces (0.0, nan, 0.0) N, pinned, length blocked'",
        lambda: pin_case([[0.0, np.nan, 0.0]], blocked=True),
    ),
    ("load case 'held'", lambda: LoadCase("held", end_loads=(0.0,) * 6 + (1.0,) + (0.0,) * 5)),
    ("load case 'axial force of 1 N, pinned'", lambda: replace(axial_case(), blocked=True)),
    (
        "load case 'opposite end moments of 1 N m about x, pinned'",
        lambda: replace(bending_case("x"), support="guided"),
    ),
)
