"""Remarks on a formula's value for one throw, one sentence each."""

from dataclasses import dataclass

from crankbase.units.quantity import format_quantity
from geometry.throw import CrankThrow
from regression.formulas.case import ThrowCase


@dataclass(frozen=True)
class Remark:
    """One sentence, and whether it makes the formula inapplicable."""

    text: str
    invalidates: bool = False


def shape_remarks(throw: CrankThrow) -> list[Remark]:
    """Features of a throw that the published formulas do not include, and whether that makes them invalid."""
    remarks = []
    if throw.further_pins:
        text = "The throw has several pins between its bearings; the formula assumes one."
        remarks.append(Remark(text, invalidates=True))
    if any(
        web.thickness not in (None, throw.web_thickness) or web.width not in (None, throw.web_width)
        for web in (throw.left_web, throw.right_web)
        if web is not None
    ):
        text = "The webs differ; the formula uses web_width and web_thickness for both."
        remarks.append(Remark(text))
    if throw.web_tip_thickness is not None or throw.web_foot_thickness is not None:
        remarks.append(Remark("The formula uses the full web thickness; this web is tapered."))
    if throw.main_journal_bore_offset or throw.pin_bore_offset:
        remarks.append(Remark("The formula treats eccentric bores as concentric."))
    if throw.oil_holes:
        remarks.append(Remark("The formula ignores oil holes."))
    return remarks


def plain_web_remarks(case: ThrowCase) -> list[Remark]:
    """For a formula whose web has its plain section B h, whatever the overlap."""
    overlap = case.throw.overlap
    if overlap <= 0.0:
        return []
    return [
        Remark(
            f"Main journal and crankpin overlap by {format_quantity(overlap, 'm')}: a formula with the plain "
            "web section overestimates the compliance, up to about three times the finite-element value."
        )
    ]


def negative_shear_remarks(case: ThrowCase) -> list[Remark]:
    """For a formula whose web shears over 2 R - D_km - D_shm only."""
    overlap = case.throw.overlap
    if overlap <= 0.0:
        return []
    return [
        Remark(
            f"Main journal and crankpin overlap by {format_quantity(overlap, 'm')}: the formula's "
            "shear term is negative there."
        )
    ]


def no_angle_remarks(case: ThrowCase) -> list[Remark]:
    """For a formula that has no angle between neighboring cranks."""
    if case.gamma_deg == 180.0:
        return []
    return [
        Remark(
            "The formula has no angle: it holds for opposite neighbors, gamma = 180 deg, and "
            f"not for {case.gamma_deg:g} deg, where the throw is stiffer.",
            invalidates=True,
        )
    ]


def open_angle_factor_remarks(case: ThrowCase, constant: str) -> list[Remark]:
    """For a formula whose factor for the angle is not published, unless the factor is given."""
    if case.gamma_deg == 180.0 or constant in case.given_constants:
        return []
    return [
        Remark(
            f"The factor {constant} for gamma = {case.gamma_deg:g} deg is not published: the value applies "
            f"to opposite neighbors, gamma = 180 deg ({constant} = 1), unless the constant {constant} is "
            "given.",
            invalidates=True,
        )
    ]


def unused_bores_remarks(case: ThrowCase) -> list[Remark]:
    """For a formula that does not include the bores."""
    if case.throw.main_journal_bore == 0.0 and case.throw.pin_bore == 0.0:
        return []
    return [Remark("The formula ignores the bores.")]
