import dataclasses
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from crankfem.files.chain.chain_file import load_chain, read_chain_text, write_chain_text
from crankfem.files.reading.data_files import shipped_names
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.shaft_line import DrivenMachine, ShaftCone, shaft_cylinder, shaft_flange
from fem.material import STEEL


def same(one, other):
    return all(
        np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for field in dataclasses.fields(Chain)
    )


@pytest.fixture
def load(tmp_path):
    def from_text(text, name="mine.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return load_chain(path)

    return from_text


def test_shipped_chains_tell_their_frequencies_and_sources():
    assert shipped_names("chain") == (
        "5rt-flex50d-plant",
        "container-drive",
        "geared-example",
        "ieee-first-benchmark",
        "mwm-six",
    )
    for name in shipped_names("chain"):
        found = load_chain(name)
        head = found.path.read_text(encoding="utf-8").split("[chain]")[0]
        told = [float(text) for text in re.findall(r"\d+\.\d", head.split("frequencies:")[1])]
        assert found.chain.modes().frequencies[1 : 1 + len(told)] == close(told, abs=0.051)
        assert found.sources
        assert all(record.source and not record.assumed for record in found.records)


def test_a_torsional_file_with_everything(load):
    found = load("""
        [chain]
        name = "all"
        kind = "torsional"
        [[chain.nodes]]
        name = "a"
        inertia = "1 kg m^2"
        ground_damping = "3 N m s/rad"
        [[chain.nodes]]
        name = "b"
        [[chain.nodes]]
        name = "propeller"
        inertia = { value = "4 kg m^2", assumed = "typical" }
        entrained_share = 0.25
        [[chain.nodes]]
        name = "pump"
        inertia = "0.1 kg m^2"
        ground_stiffness = "2 N m/rad"
        [[chain.elements]]
        shape = "cylinder"
        length = "2 m"
        diameter = "100 mm"
        bore = "40 mm"
        parts = 2
        loss_factor = 0.01
        [[chain.elements]]
        shape = "cone"
        length = "300 mm"
        left_diameter = "100 mm"
        right_diameter = "80 mm"
        [[chain.elements]]
        nodes = ["a", "propeller"]
        stiffness = "5e5 N m/rad"
        damping = "7 N m s/rad"
        distributed_inertia = "0.2 kg m^2"
        [[chain.elements]]
        nodes = ["a", "b"]
        shape = "flange"
        length = "50 mm"
        diameter = "300 mm"
        [[chain.gears]]
        driver = "a"
        driven = "pump"
        ratio = -2.0
        [[chain.dashpots]]
        nodes = ["a", "b"]
        damping = "1 N m s/rad"
        [[chain.dampers]]
        type = "rubber"
        node = "a"
        name = "ring"
        ring_inertia = "0.3 kg m^2"
        hub_inertia = "0.2 kg m^2"
        stiffness = "1e5 N m/rad"
        loss_factor = 0.2
        """)
    chain = found.chain
    assert chain.names == ("a", "a - b 1", "b", "propeller", "pump", "ring")
    assert chain.inertia == close([1.2, 0.0, 0.0, 5.0, 0.1, 0.3])
    assert chain.connections == ((0, 1), (1, 2), (2, 3), (0, 3), (0, 2), (0, 5))
    half = shaft_cylinder(1.0, 0.1, 0.04, STEEL)
    cone, flange = (
        ShaftCone(0.3, 0.1, 0.08, material=STEEL),
        shaft_flange(0.05, 0.3, material=STEEL),
    )
    compliances = [half.torsional_compliance] * 2 + [cone.torsional_compliance, 2e-6]
    assert 1.0 / chain.stiffness == close([*compliances, flange.torsional_compliance, 1e-5])
    assert chain.distributed_inertia == close(
        [*[half.polar_inertia] * 2, cone.polar_inertia, 0.2, flange.polar_inertia, 0.0]
    )
    assert chain.loss_factor.tolist() == [0.01, 0.01, 0.0, 0.0, 0.0, 0.2]
    assert chain.damping.tolist() == [0.0, 0.0, 0.0, 7.0, 0.0, 0.0]
    assert chain.ground.tolist() == [0.0, 0.0, 0.0, 0.0, 2.0, 0.0]
    assert chain.ground_damping.tolist() == [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert chain.gears == (Gear(0, 4, -2.0),)
    assert chain.dashpots == (Dashpot(0, 2, 1.0),)
    assert [record.field for record in found.records if record.assumed] == [
        "chain.nodes[2].inertia"
    ]


@pytest.mark.parametrize(
    ("kind", "key", "assumed"),
    [("torsional", "shear_modulus", 2.1e11 / 2.6), ("axial", "youngs_modulus", 2.1e11)],
)
def test_a_modulus_of_all_pieces_or_of_one(load, kind, key, assumed):
    unit = {"torsional": 'inertia = "1 kg m^2"', "axial": 'mass = "1 kg"'}[kind]
    piece = '[[chain.elements]]\nshape = "cylinder"\nlength = "2 m"\ndiameter = "100 mm"\n'
    nodes = "".join(f'[[chain.nodes]]\nname = "{name}"\n{unit}\n' for name in "abc")

    def chain(of_all="", of_one="", pieces=piece):
        head = f'[chain]\nname = "shafts"\nkind = "{kind}"\n'
        return load(f"{head}{of_all}{nodes}{pieces}{piece}{of_one}").chain

    steel = chain()
    iron, other = (f'{key} = "{size} GPa"\n' for size in (120, 90))
    changed = chain(iron, other)
    assert changed.stiffness / steel.stiffness == close([120e9 / assumed, 90e9 / assumed])
    assert changed.distributed_inertia == close(steel.distributed_inertia)
    spring = {"torsional": "N m/rad", "axial": "N/m"}[kind]
    alone = f'[[chain.elements]]\nstiffness = "1e5 {spring}"\n'
    with pytest.raises(
        InputError, match=rf"chain\.elements\[0\]\.{key}: given together with stiff"
    ):
        chain(pieces=alone + other)
    with pytest.raises(InputError, match=rf"chain\.{key}: given without a piece of shaft"):
        load(f'[chain]\nname = "springs"\nkind = "{kind}"\n{iron}{nodes}{alone}{alone}')


def test_an_element_over_mean_torque_and_temperature_in_one_table(load):
    chain = load("""
        [chain]
        name = "coupled"
        kind = "torsional"
        [[chain.nodes]]
        name = "a"
        inertia = "1 kg m^2"
        [[chain.nodes]]
        name = "b"
        inertia = "2 kg m^2"
        [[chain.elements]]
        stiffness = "1000 N m/rad"
        damping = "3 N m s/rad"
        [chain.elements.variation]
        torque = ["0 N m", "2 kN m"]
        temperature = ["20 degC", "80 degC", "100 degC"]
        stiffness = [[1.0, 0.8, 0.7], [2.0, 1.6, 1.4]]
        at_torque = "500 N m"
        at_temperature = "50 degC"
        """).chain
    assert chain.stiffness == close([1000.0 * 1.25 * 0.9])
    assert chain.damping.tolist() == [3.0]
    assert not chain.varying


def test_an_axial_file_in_lists(load):
    found = load("""
        [chain]
        name = "rod"
        kind = "axial"
        mass = ["50 kg", "0.1 t"]
        stiffness = ["1e9 N/m"]
        ground_stiffness = ["0 N/m", "3e8 N/m"]
        damping = "2 N s/m"
        loss_factor = [0.1]
        [[chain.dampers]]
        node = "node 0"
        damping = "4e4 N s/m"
        """)
    expected = Chain(
        [50.0, 100.0], [1e9], {1: 3e8}, damping=2.0, loss_factor=0.1, ground_damping={0: 4e4}
    )
    assert same(found.chain, expected)


GEARED = """
torsional chain: two shafts   # comment

motor  0.4e-3 kg m^2  ground damping 2 N m s/rad
  10 kN m/rad  loss 0.02  damping 3 N m s/rad
gear 1  25e-6 kg m^2
  dashpot 0.5 N m s/rad
  gear -2  to gear 2
rotor  0 kg m^2  ground 5 N m/rad
  5000 N m/rad  inertia 2e-4 kg m^2
gear 2  1 kg m^2
  6000 N m/rad  from gear 1  to motor
"""


def test_plain_text(load):
    found = load(GEARED, "mine.txt")
    assert (found.name, found.kind) == ("two shafts", "torsional")
    expected = Chain(
        [4e-4, 25e-6, 0.0, 1.0],
        [1e4, 5000.0, 6000.0],
        {2: 5.0},
        connections=[(0, 1), (2, 3), (1, 0)],
        damping=[3.0, 0.0, 0.0],
        loss_factor=[0.02, 0.0, 0.0],
        ground_damping={0: 2.0},
        distributed_inertia=[0.0, 2e-4, 0.0],
        dashpots=[Dashpot(1, 2, 0.5)],
        gears=[Gear(1, 3, -2.0)],
        names=["motor", "gear 1", "rotor", "gear 2"],
    )
    assert same(found.chain, expected)


@st.composite
def chains(draw):
    count = draw(st.integers(1, 5))
    size = st.floats(1e-3, 1e9)
    small = st.sampled_from([0.0, 0.1, 1.0 / 3.0])
    order = draw(st.permutations(range(count)))
    # A tree by numbers at random, so that rows, branches and any order of elements come up.
    pairs = [(order[draw(st.integers(0, k - 1))], order[k]) for k in range(1, count)]
    if draw(st.booleans()):
        pairs = [(k - 1, k) for k in range(1, count)]

    def each(strategy, number):
        return draw(st.lists(strategy, min_size=number, max_size=number))

    return Chain(
        each(size, count),
        each(size, len(pairs)),
        each(small, count),
        connections=pairs,
        damping=each(small, len(pairs)),
        loss_factor=each(small, len(pairs)),
        ground_damping=each(small, count),
        distributed_inertia=each(small, len(pairs)),
        dashpots=[Dashpot(0, count - 1, draw(size))] if count > 1 else [],
        gears=[Gear(0, 1, 1.0)] if count > 1 and draw(st.booleans()) else [],
    )


@settings(max_examples=20, deadline=None)
@given(chains(), st.sampled_from(["torsional", "axial"]))
def test_text_reads_back_to_the_last_digit(chain, kind):
    read = read_chain_text(write_chain_text(chain, kind, "any"))
    assert (read.kind, read.name) == (kind, "any")
    assert same(read.chain, chain)


def test_a_spring_to_ground_in_text_may_be_named_as_in_other_files():
    lines = (
        "torsional\na  1 kg m^2  {} 5 Nm/rad  ground damping 2 Nms/rad\n  3 Nm/rad\nb  1 kg m^2\n"
    )
    for word in ("ground", "ground stiffness"):
        chain = read_chain_text(lines.format(word)).chain
        assert chain.ground.tolist() == [5.0, 0.0]
        assert chain.ground_damping.tolist() == [2.0, 0.0]


def test_names_that_text_cannot_hold():
    for name in ("two  spaces", "a # b", " a", ""):
        with pytest.raises(InputError, match=r"^names: "):
            write_chain_text(Chain([1.0], [], names=[name]), "axial")
        if name:
            with pytest.raises(InputError, match=r"^name: "):
                write_chain_text(Chain([1.0], []), "axial", name)
    for title in ("one\ntwo", "one\x85two"):
        with pytest.raises(InputError, match=r"^name: "):
            write_chain_text(Chain([1.0], []), "axial", title)
    with pytest.raises(InputError, match=r"^kind: "):
        write_chain_text(Chain([1.0], []), "bending")


def test_files_that_are_not_there():
    with pytest.raises(InputError, match="nothing-here"):
        load_chain("nothing-here")


def test_text_that_is_too_large_is_no_chain(tmp_path):
    path = tmp_path / "chain.txt"
    path.write_text("torsional\n" + "# remark\n" * 200_000, encoding="utf-8")
    with pytest.raises(InputError, match=r"1\.8 MB"):
        load_chain(path)


PLAIN = """
    [chain]
    name = "plain"
    kind = "torsional"
    [[chain.nodes]]
    name = "a"
    {a}
    [[chain.nodes]]
    name = "b"
    inertia = "2 kg m^2"
    [[chain.elements]]
    {spring}
    {more}
"""
BASE = """
    [chain.base]
    power = "100 MW"
    speed = "3000 1/min"
    frequency = "100 Hz"
"""


@pytest.mark.parametrize(
    ("a", "spring", "more", "inertia", "stiffness", "loss"),
    [
        ('flywheel_effect = "8 kg m^2"', 'flexibility = "5e-6 rad/(N m)"', "", 2.0, 2e5, 0.0),
        ('inertia = "1 lb ft2"', 'stiffness = "8 lb in/rad"', "", 0.0421401, 0.903879, 0.0),
        (
            'inertia = "1 lb in s2"',
            'stiffness = "1 N m/rad"\nmagnifier = 5.0',
            "",
            0.1129848,
            1.0,
            0.2,
        ),
        (
            'inertia_constant = "2 s"',
            "per_unit_stiffness = 3.0\nrelative_damping = 1.0",
            BASE,
            4.0 * 1e8 / (100.0 * np.pi) ** 2,
            3.0 * 1e8 / (100.0 * np.pi) * 2.0,
            0.5 / np.pi,
        ),
    ],
)
def test_other_forms_of_a_value(load, a, spring, more, inertia, stiffness, loss):
    chain = load(PLAIN.format(a=a, spring=spring, more=more)).chain
    assert chain.inertia[0] == close(inertia, rel=1e-6)
    assert chain.stiffness[0] == close(stiffness, rel=1e-6)
    assert chain.loss_factor[0] == close(loss, abs=1e-12)


@pytest.mark.parametrize(
    ("a", "spring", "complaint"),
    [
        (
            'inertia = "1 kg m^2"\nflywheel_effect = "4 kg m^2"',
            'stiffness = "1 N m/rad"',
            "GD2|inertia",
        ),
        ('inertia_constant = "1 s"', 'stiffness = "1 N m/rad"', "chain.base"),
        (
            'inertia = "1 kg m^2"',
            'stiffness = "1 N m/rad"\nflexibility = "1 rad/(N m)"',
            "one of the two",
        ),
        ('inertia = "1 kg m^2"', 'stiffness = "1 N m/rad"\nmagnifier = 0.1', "magnifier"),
        ('inertia = "1 kg m^2"', 'flexibility = "0 rad/(N m)"', "stiffness|flexibility"),
    ],
)
def test_other_forms_that_contradict(load, a, spring, complaint):
    with pytest.raises(InputError, match=complaint):
        load(PLAIN.format(a=a, spring=spring, more=""))


LISTED = """
    [chain]
    name = "listed"
    kind = "torsional"
    names = ["a", "b", "c", "d"]
    inertia = ["1 kg m^2", "2 kg m^2", "3 kg m^2", "4 kg m^2"]
    flexibility = ["1e-5 rad/(N m)", "0 rad/(N m)", "2e-5 rad/(N m)"]
    relative_damping = {damping}
"""
GEAR = '[[chain.gears]]\ndriver = "b"\ndriven = "c"\nratio = -3.0\n'


def test_a_flexibility_of_zero_is_rigid_and_one_speed_leaves_the_frequencies(load):
    rigid = load(LISTED.format(damping=1.0)).chain
    plain = Chain([1.0, 5.0, 4.0], [1e5, 5e4])
    assert rigid.modes().frequencies == close(plain.modes().frequencies, abs=1e-5)
    assert rigid.loss_factor == close(0.5 / np.pi)
    referred = LISTED.format(damping=1.0) + '    referred_to = "a"\n' + GEAR
    geared = load(referred).chain
    assert geared.modes().frequencies == close(plain.modes().frequencies, abs=1e-5)
    assert geared.inertia[2:] == close(np.array([3.0, 4.0]) / 9.0)
    with pytest.raises(InputError, match="referred_to"):
        load(referred.replace('referred_to = "a"', 'referred_to = "e"'))
    with pytest.raises(InputError, match="magnifier"):
        load(
            LISTED.format(damping=1.0)
            .replace("relative_damping", "magnifier")
            .replace("1.0", "0.0")
        )


def test_a_couplings_damping_names_its_convention():
    machine = {"inertia": 200.0, "coupling_stiffness": 1e5}
    factor = DrivenMachine(**machine, coupling_loss_factor=0.2).ring.loss_factor
    psi = DrivenMachine(**machine, coupling_relative_damping=0.4 * np.pi).ring.loss_factor
    magnifier = DrivenMachine(**machine, coupling_magnifier=5.0).ring.loss_factor
    assert [psi, magnifier] == close([factor] * 2)
    with pytest.raises(InputError, match="loss_factor"):
        DrivenMachine(**machine, coupling_loss_factor=0.2, coupling_magnifier=5.0)
