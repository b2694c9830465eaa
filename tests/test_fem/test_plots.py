"""Diagrams, tables and grids of finite element results: their numbers are the objects' own.

Compliances are drawn in 1e-9 of their unit; dividing and multiplying by that leaves round-off.
"""

from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from fem.analysis import AxialAnalysis, ThrowAnalysis
from fem.end_reactions import EndReaction, Reactions
from fem.fillet_peaks import FilletPeak, FilletStresses, ReadingQuality, throw_fillets, unit_loads
from fem.material import STEEL
from fem.modes import DynamicSuperelement, ThrowModes
from fem.plots import ANGLES_DEG
from fem.superelement import shaft_compliances
from fem.supports import Neighbors
from fem.symmetry import RADIAL, SymmetryClass, axial_class
from geometry.mass import mass_properties
from refusals import refused


@pytest.fixture(scope="module")
def analysis(throw, mesh, classes, superelement):
    """An analysis on the coarse mesh that all tests share."""
    masses = mass_properties(mesh, STEEL.density)
    return ThrowAnalysis(
        throw=throw,
        material=STEEL,
        superelement=superelement,
        mesh=mesh,
        classes=classes,
        masses=masses,
        error_estimate=0.05,
        accuracy=0.1,
    )


@pytest.fixture(scope="module")
def shaft(superelement):
    return shaft_compliances([superelement] * 3, crank_angles_deg=[0.0, 120.0, 240.0])


@pytest.fixture(scope="module")
def stresses(throw):
    loads, fillets = unit_loads(RADIAL[None])[:2], throw_fillets(throw.parts)
    peaks = tuple(
        FilletPeak(
            load=load,
            fillet=fillet,
            principal=-(2.0 + column + number),
            principal_place=np.array([0.0, 0.1, 0.2]),
            principals=np.zeros(3),
            von_mises=3.0,
            von_mises_place=np.zeros(3),
            shear=1.5,
            shear_place=np.zeros(3),
            nominal=2.0,
            error_estimate=0.1,
            quality=ReadingQuality(0.0, 0.01),
        )
        for column, load in enumerate(loads)
        for number, fillet in enumerate(fillets)
    )
    return FilletStresses(throw, peaks, (), None, None, 3.0, 0.1)


@pytest.mark.parametrize(
    ("quantity", "value", "unit"),
    [
        ("axial_compliance", ThrowAnalysis.axial_compliance, "m/N"),
        ("torsional_compliance", ThrowAnalysis.torsional_compliance, "rad/(N m)"),
        ("influence_coefficient", ThrowAnalysis.influence_coefficient, "m/N"),
    ],
)
def test_compliances_over_the_angle(analysis, quantity, value, unit):
    axes = analysis.plot_over_angle(quantity=quantity)
    curve, guided, pinned = axes.lines
    assert curve.get_xdata() == close(ANGLES_DEG)
    between = value(analysis, Neighbors(60.0, 60.0)) * 1e9
    # The closed law of the axial answers holds to the round-off of its three numbers.
    assert curve.get_ydata()[12] == close(between, rel=1e-6)
    assert guided.get_ydata()[0] == close(value(analysis, "guided") * 1e9)
    assert pinned.get_ydata()[0] == close(value(analysis, "pinned") * 1e9)
    assert f"$10^{{-9}}$ {unit}" in axes.get_ylabel()


@pytest.mark.slow
def test_an_analysis_draws_its_throw(analysis):
    drawn = [text.get_text() for text in analysis.plot().texts]
    assert drawn == [text.get_text() for text in analysis.throw.plot().texts]
    assert analysis.plot(view="left end", dimensions=False).get_xlabel()


def test_only_known_quantities(analysis, shaft):
    for plot in (analysis.plot_over_angle, analysis.angle_law.plot, shaft.plot):
        with refused("quantity"):
            plot(quantity="mass")
    with refused("content"):
        analysis.to_pandas("mass")


def test_the_band_is_the_estimated_error(analysis):
    vertices = analysis.plot_over_angle().collections[0].get_paths()[0].vertices
    highest = analysis.over_angle().max() * 1e9
    assert vertices[:, 1].max() == close(1.05 * highest)


def test_tables_of_a_throw(analysis):
    frame = analysis.to_pandas()
    assert frame.loc["pinned", "axial_compliance"] == analysis.axial_compliance()
    assert frame.loc["neighbors 120 deg", "torsional_compliance"] == (
        analysis.torsional_compliance(Neighbors(120.0, 120.0))
    )
    assert frame.attrs["units"]["influence_coefficient"] == "m/N"
    stiffness = analysis.to_pandas("stiffness")
    assert stiffness.loc["right Fz", "left uz"] == analysis.stiffness[8, 2]
    assert stiffness.to_numpy() == close(analysis.stiffness)


def test_the_grid_of_a_throw(analysis):
    found = analysis.to_xarray()
    assert found.stiffness.sel(load="left Mx", motion="right rx") == analysis.stiffness[3, 9]
    assert found.axial_compliance.sel(gamma_deg=90.0) == analysis.over_angle()[18]
    assert found.axial_compliance.attrs["units"] == "m/N"
    assert found.gamma_deg.attrs == {
        "units": "deg",
        "long_name": "angle between neighboring cranks",
    }


def test_the_axial_answers_alone(analysis, mesh, classes):
    alone = AxialAnalysis(
        throw=analysis.throw,
        material=STEEL,
        mesh=mesh,
        part=next(one for one in classes if one.symmetry == axial_class(mesh.part)),
        error_estimate=0.05,
        accuracy=0.1,
    )
    frame = alone.to_pandas()
    assert frame.loc["guided", "axial_compliance"] == alone.axial_compliance("guided")
    plain = alone.discrete
    assert plain.axial_compliance() == close(analysis.discrete.axial_compliance(), rel=1e-10)
    assert plain.error_estimate == 1.0 - plain.axial_compliance() / alone.axial_compliance()
    with refused("plot"):
        replace(analysis, throw=None).plot()


def test_the_angle_law(analysis):
    law = analysis.angle_law
    axes = law.plot(quantity="influence_coefficient")
    assert axes.lines[0].get_ydata() == close(law.influence(ANGLES_DEG) * 1e9)
    frame = law.to_pandas([0.0, 180.0])
    assert frame["axial_compliance"].tolist() == close([law.in_line, law.opposite])
    assert law.to_xarray([90.0]).axial_compliance.item() == law.axial(90.0)
    for wrong in ([[0.0, 1.0]], [], [[0.0], [1.0, 2.0]]):
        for to in (law.to_pandas, law.to_xarray):
            with refused("gamma_deg"):
                to(wrong)
    with refused("quantity"):
        law.plot(quantity=["axial_compliance"])


def test_loads_and_motions_as_tables(analysis):
    reactions = analysis.reactions((0.0, -1e5, 0.0))
    frame = reactions.to_pandas()
    assert frame.loc["left", "Fy"] == reactions.left.force[1]
    two = EndReaction(np.zeros((2, 3)), np.zeros((2, 3)))
    with refused("plot"):
        Reactions(two, two).plot()
    assert frame.loc["right", "Mx"] == reactions.right.moment[0]
    assert frame.attrs["units"] == {"place": ""} | dict.fromkeys(("Fx", "Fy", "Fz"), "N") | (
        dict.fromkeys(("Mx", "My", "Mz"), "N m")
    )
    response = analysis.pin_response((0.0, -1e5, 0.0))
    frame = response.to_pandas()
    assert frame.loc["pin", "uy"] == response.pin.displacement[1]
    assert frame.loc["right", "rx"] == response.right.rotation[0]


def test_a_shaft_in_bars_and_cells(shaft):
    axes = shaft.plot(quantity="torsional")
    assert [bar.get_height() for bar in axes.patches] == close(shaft.torsional * 1e9)
    assert "rad/(N m)" in axes.get_ylabel()
    axes = shaft.plot(quantity="through")
    assert [bar.get_height() for bar in axes.patches] == close(shaft.through * 1e9)
    assert axes.get_ylabel().endswith("[$10^{-9}$ 1/N]")
    axes = shaft.plot(quantity="influence")
    assert np.asarray(axes.images[0].get_array()) == close(shaft.influence * 1e9)
    assert len(axes.texts) == 9
    assert shaft.to_pandas()["through"].to_numpy() == close(shaft.through)
    found = shaft.to_xarray()
    assert found.influence.sel(throw=2, pin=3) == shaft.influence[1, 2]
    assert found.through.attrs["units"] == "1/N"


def test_fillet_factors(stresses):
    axes = stresses.plot()
    factors = [peak.factor for peak in stresses.peaks]
    assert [bar.get_height() for bar in axes.patches] == close(factors)
    assert axes.get_ylabel().endswith("[1]")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["axial force", "torque"]
    frame = stresses.to_pandas()
    assert frame["factor"].tolist() == factors
    assert frame["principal"].tolist() == [peak.principal for peak in stresses.peaks]
    found = stresses.to_xarray()
    assert found.factor.sel(load="torque", fillet="pin, left web") == 0.5 * (2.0 + 1.0 + 1.0)
    assert found.von_mises_factor.values == close(1.5)
    with refused("criterion"):
        stresses.plot(criterion="Tresca")


def test_frequencies():
    symmetry = SymmetryClass(1, 1)
    modes = ThrowModes(
        frequencies=np.array([700.0, 1100.0]),
        symmetries=(symmetry, symmetry),
        names=("bending in the crank plane, symmetric", "torsion, antisymmetric"),
        shapes=np.zeros((1, 3, 2)),
        residuals=np.array([1e-12, 2e-12]),
        rigid_frequencies=np.zeros(6),
        solver="superlu",
    )
    many = replace(modes, frequencies=np.arange(1.0, 25.0), symmetries=(symmetry,) * 24)
    many = replace(many, names=modes.names * 12)
    assert len(many.plot().get_xticks()) < 24  # the axis has no room for every number
    axes = modes.plot()
    assert [line.get_ydata()[0] for line in axes.lines] == [700.0, 1100.0]
    assert [line.get_label() for line in axes.lines] == ["bending in the crank plane", "torsion"]
    assert axes.get_ylabel() == "natural frequency [Hz]"
    assert modes.to_pandas()["frequency"].tolist() == [700.0, 1100.0]
    element = DynamicSuperelement(
        stiffness=np.eye(15),
        mass=np.eye(15),
        pin_loads=np.zeros((1, 15, 6)),
        frequencies=np.array([900.0, 1200.0, 3000.0]),
        natural=2,
        symmetries=(symmetry,) * 3,
        shapes=np.zeros((1, 3, 3)),
        highest_frequency=800.0,
        cutoff_factor=1.5,
        solver="superlu",
    )
    assert element.to_pandas()["kind"].tolist() == ["natural mode", "natural mode", "correction"]
    axes = element.plot()
    assert axes.lines[-1].get_ydata()[0] == 800.0
    guyan = replace(element, frequencies=np.zeros(0), natural=0, symmetries=())
    assert len(guyan.plot().lines) == 1
    assert guyan.to_pandas().empty
