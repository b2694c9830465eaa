"""Stress concentration of crank webs by UR M53 or elements, and the nominal stresses that it multiplies."""

import math
from dataclasses import KW_ONLY, fields
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    check_shape,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_number,
)
from crankbase.choices import check_choice, check_kind
from crankbase.errors import InputError
from crankbase.sentences import in_si
from crankbase.summaries import frozen
from dynamics.cycle import checked_strokes
from dynamics.response.loads import section_modulus

M53_SOURCE = (
    "IACS unified requirement M53 Rev.5, as carried into the Korean Register's Rules for Steel Ships 2025, "
    "Part 5 Guidance, Annex 5-3"
)
# Between these the rule's factors hold: lengths over the pin's diameter.
RANGES = {
    "overlap": ("s", -math.inf, 0.5),
    "web_thickness": ("w", 0.2, 0.8),
    "web_width": ("b", 1.1, 2.2),
    "pin_fillet_radius": ("r", 0.03, 0.13),
    "journal_fillet_radius": ("r", 0.03, 0.13),
    "pin_bore": ("d_H", 0.0, 0.8),
    "journal_bore": ("d_G", 0.0, 0.8),
    "oil_hole_diameter": ("d_O", 0.0, 0.2),
}
LENGTHS = ("pin_diameter", "journal_diameter", "crank_radius", "web_thickness", "web_width")
MAY_BE_ZERO = (
    *("pin_fillet_radius", "journal_fillet_radius", "pin_bore", "journal_bore"),
    *("pin_recess", "journal_recess", "oil_hole_diameter"),
)


@frozen("pin_diameter [m]", "journal_diameter [m]", "overlap [m]", "web_thickness [m]")
class CrankWeb:
    """One web of a throw with the adjacent pin and main journal [m].

    Parameters
    ----------
    pin_diameter, journal_diameter : float
        D, D_G.
    crank_radius : float
        E.
    web_thickness, web_width : float
        W, B; of a semi-built crank B at the center of the pin's fillet.
    pin_fillet_radius, journal_fillet_radius : float
        R_H, R_G.
    pin_bore, journal_bore : float, optional
        D_BH, D_BG.
    pin_recess, journal_recess : float, optional
        T_H, T_G: depth to which the fillets are recessed into the web.
    oil_hole_diameter : float, optional
        D_O of a radial hole in the pin; 0 for none.
    semi_built : bool, optional
        Whether the journal is shrunk into the web: then it has no fillet to be assessed.

    Raises
    ------
    InputError
        If a length is not above zero (recesses, fillets and holes: negative), or a bore not smaller than
        its journal.
    """

    pin_diameter: float
    journal_diameter: float
    crank_radius: float
    web_thickness: float
    web_width: float
    pin_fillet_radius: float
    journal_fillet_radius: float
    _: KW_ONLY
    pin_bore: float = 0.0
    journal_bore: float = 0.0
    pin_recess: float = 0.0
    journal_recess: float = 0.0
    oil_hole_diameter: float = 0.0
    semi_built: bool = False

    def __post_init__(self) -> None:
        for name in LENGTHS:
            positive_number(name, getattr(self, name), "m", "it is a length")
        for name in MAY_BE_ZERO:
            nonnegative_number(name, getattr(self, name), "m", "it is a length")
        for part in ("pin", "journal"):
            bore, diameter = getattr(self, f"{part}_bore"), getattr(self, f"{part}_diameter")
            if bore >= diameter:
                raise InputError(
                    f"{part}_bore: given {in_si(bore, 'm')}; allowed is less than the diameter of "
                    f"{in_si(diameter, 'm')}, because a wall is left."
                )
        if self.section_thickness <= 0.0:
            raise InputError(
                f"pin_recess: given {in_si(self.pin_recess, 'm')}; allowed is less than web thickness and "
                f"pin fillet radius together, {in_si(self.web_thickness + self.pin_fillet_radius, 'm')}, "
                "because a web is left."
            )

    @property
    def overlap(self) -> float:
        """S of pin and journal, negative without overlap [m]."""
        return 0.5 * (self.pin_diameter + self.journal_diameter) - self.crank_radius

    @property
    def section_thickness(self) -> float:
        """W, reduced by a recess deeper than the pin's fillet if pin and journal do not overlap [m].

        W_red = W - (T_H - R_H), of semi-built cranks at any overlap.
        """
        cut = self.pin_recess - self.pin_fillet_radius
        reduced = (self.semi_built or self.overlap < 0.0) and cut > 0.0
        return self.web_thickness - cut if reduced else self.web_thickness

    @property
    def bending_modulus(self) -> float:
        """W_eqw = B W^2 / 6 of the web's section [m^3]."""
        return self.web_width * self.section_thickness**2 / 6.0

    def ratio(self, name: str) -> float:
        """Return a length over the diameter of the pin; the web's thickness as of `section_thickness`.

        Raises
        ------
        InputError
            If the web has no length of that name.
        """
        names = [part.name for part in fields(self) if part.name != "semi_built"]
        check_choice("name", name, [*names, "overlap"], "these are the lengths of a crank web")
        length = "section_thickness" if name == "web_thickness" else name
        return float(getattr(self, length)) / self.pin_diameter

    def place_radius(self, place: str) -> tuple[float, float]:
        """Return the diameter and the radius that determine the strength of a fillet or oil hole [m]."""
        check_choice("place", place, PLACES, "the rule judges these")
        return {
            "pin fillet": (self.pin_diameter, self.pin_fillet_radius),
            "journal fillet": (self.journal_diameter, self.journal_fillet_radius),
            "oil hole": (self.pin_diameter, 0.5 * self.oil_hole_diameter),
        }[place]


PLACES = ("pin fillet", "journal fillet", "oil hole")


def check_ranges(web: CrankWeb) -> None:
    """Refuse a web for which the rule has no factors of stress concentration."""
    for name in RANGES:
        if web.semi_built and name == "journal_fillet_radius":
            continue
        check_ratio(f"{name} over pin_diameter", name, web.ratio(name))
    if not web.semi_built:
        ratio = web.journal_fillet_radius / web.journal_diameter
        check_ratio("journal_fillet_radius over journal_diameter", "journal_fillet_radius", ratio)


def check_ratio(what: str, name: str, value: float, lowest: float | None = None) -> None:
    """Refuse a ratio outside its range, or below the `lowest` of one factor."""
    symbol, low, high = RANGES[name]
    low = low if lowest is None else lowest
    slack = 1e-12
    if low - slack <= value <= high + slack:
        return
    allowed = f"{low:g} to {high:g}" if math.isfinite(low) else f"up to {high:g}"
    raise InputError(
        f"{what} ({symbol}): given {value:.4g}; allowed is {allowed}, because the formulas of UR M53 hold "
        "there alone; use finite elements."
    )


Coefficients = Literal["printed", "suspected"]
COEFFICIENTS: tuple[Coefficients, ...] = get_args(Coefficients)
# Of b^3 in alpha_T and beta_T, and of w^2 in beta_B: as the Korean Register prints them, and as a misprint
# would have come from. No text at hand confirms the second; the printed ones are on the safe side.
DOUBTFUL: dict[Coefficients, tuple[float, float]] = {
    "printed": (0.85, 1.527),
    "suspected": (0.857, 1.5276),
}
# Below this overlap some parts of the formulas stay as they are there, and beta_Q ends: it falls to zero.
LEAST_OVERLAP, LEAST_OVERLAP_OF_SHEAR = -0.5, -0.6
FACTORS = (
    *("alpha_bending", "alpha_torsion", "beta_bending", "beta_shear", "beta_torsion"),
    *("gamma_bending", "gamma_torsion"),
)


@frozen("alpha_bending", "alpha_torsion", "beta_bending", "beta_torsion", "coefficients")
class ConcentrationFactors:
    """Factors on the nominal stresses of a web's pin and journal, each calculated on demand.

    Parameters
    ----------
    coefficients : {"printed", "suspected"}, optional
        Two coefficients of the rule are doubtful: 0.85 of b^3 in alpha_T and beta_T (suspected is 0.857)
        and 1.527 of w^2 in beta_B (1.5276). The printed ones give larger factors.

    Raises
    ------
    InputError
        If a ratio of the web is outside the range of the formulas.

    Notes
    -----
    Lengths over the pin's diameter: s overlap, w web thickness, b web width, r fillet radius, d_G and d_H
    bores of journal and pin, t_G and t_H recesses, d_O oil hole; u = 1 - s, s no less than -0.5. Source:
    `M53_SOURCE`. With r of the pin's fillet in alpha, of the journal's in beta::

        alpha_B = 2.6914 f(s,w) 2.1790 w^0.7171 (0.6840 - 0.0077 b + 0.1473 b^2) 0.2081 r^-0.5231
                  (0.9993 + 0.27 d_G - 1.0211 d_G^2 + 0.5306 d_G^3)
                  (0.9978 + 0.3145 d_H - 1.5241 d_H^2 + 2.4147 d_H^3) f
        f(s,w)  = -4.1883 + 29.2004 w - 77.5925 w^2 + 91.9454 w^3 - 40.0416 w^4
                  + u (9.5440 - 58.3480 w + 159.3415 w^2 - 192.5846 w^3 + 85.2916 w^4)
                  + u^2 (-3.8399 + 25.0444 w - 70.5571 w^2 + 87.0328 w^3 - 39.1832 w^4)
        alpha_T = 0.8 r^(-0.322 + 0.1015 u) (7.8955 - 10.654 b + 5.3482 b^2 - 0.85 b^3) w^-0.145
        beta_B  = 2.7146 g(s,w) 2.2422 w^0.7548 (0.5616 + 0.1197 b + 0.1176 b^2) 0.1908 r^-0.5568
                  (1.0012 - 0.6441 d_G + 1.2265 d_G^2) (1.0022 - 0.1903 d_H + 0.0073 d_H^2) f
        g(s,w)  = -1.7625 + 2.9821 w - 1.527 w^2 + u (5.1169 - 5.8089 w + 3.1391 w^2)
                  + u^2 (-2.1567 + 2.3297 w - 1.2952 w^2)
        beta_Q  = 3.0128 (0.4368 + 2.1630 u - 1.5212 u^2) w / (0.0637 + 0.9369 w) (b - 0.5)
                  0.5331 r^-0.2038 (0.9937 - 1.1949 d_H + 1.7373 d_H^2) f, here u = 1 - s at any s
        beta_T  = alpha_T with the journal's fillet over the journal's diameter for r
        gamma_B = 3 - 5.88 d_O + 34.6 d_O^2, gamma_T = 4 - 6 d_O + 30 d_O^2
        f       = 1 + (t_H + t_G) (1.8 + 3.2 s), no less than 1

    alpha and beta in bending and shear are by von Mises, in torsion by the largest shear, gamma by the
    largest principal stress.
    """

    web: CrankWeb
    coefficients: Coefficients = "printed"

    def __post_init__(self) -> None:
        check_choice("coefficients", self.coefficients, COEFFICIENTS, "two are doubtful")
        check_ranges(self.web)

    @property
    def alpha_bending(self) -> float:
        """alpha_B of the pin's fillet, on the bending stress of the web."""
        u, w, b, d_g, d_h = self._u, self._w, self._b, self._d_g, self._d_h
        r = self.web.ratio("pin_fillet_radius")
        of_web = (
            _polynomial(w, -4.1883, 29.2004, -77.5925, 91.9454, -40.0416)
            + u * _polynomial(w, 9.5440, -58.3480, 159.3415, -192.5846, 85.2916)
            + u**2 * _polynomial(w, -3.8399, 25.0444, -70.5571, 87.0328, -39.1832)
        )
        return (
            2.6914
            * of_web
            * _power(w, 2.1790, 0.7171)
            * _polynomial(b, 0.6840, -0.0077, 0.1473)
            * _power(r, 0.2081, -0.5231)
            * _polynomial(d_g, 0.9993, 0.27, -1.0211, 0.5306)
            * _polynomial(d_h, 0.9978, 0.3145, -1.5241, 2.4147)
            * self._recess
        )

    @property
    def alpha_torsion(self) -> float:
        """alpha_T of the pin's fillet, on the torsional stress of the pin."""
        return self._torsion(self.web.ratio("pin_fillet_radius"))

    @property
    def beta_bending(self) -> float:
        """beta_B of the journal's fillet, on the bending stress of the web."""
        u, w, b, d_g, d_h = self._u, self._w, self._b, self._d_g, self._d_h
        r = self._journal_fillet
        of_web = (
            _polynomial(w, -1.7625, 2.9821, -DOUBTFUL[self.coefficients][1])
            + u * _polynomial(w, 5.1169, -5.8089, 3.1391)
            + u**2 * _polynomial(w, -2.1567, 2.3297, -1.2952)
        )
        return (
            2.7146
            * of_web
            * _power(w, 2.2422, 0.7548)
            * _polynomial(b, 0.5616, 0.1197, 0.1176)
            * _power(r, 0.1908, -0.5568)
            * _polynomial(d_g, 1.0012, -0.6441, 1.2265)
            * _polynomial(d_h, 1.0022, -0.1903, 0.0073)
            * self._recess
        )

    @property
    def beta_shear(self) -> float:
        """beta_Q of the journal's fillet, on the shear stress of the web.

        Raises
        ------
        InputError
            If pin and journal are apart by more than 0.6 pin diameters: the formula falls to zero there.
        """
        s = self.web.ratio("overlap")
        what = "overlap over pin_diameter, of the shear factor beta_Q"
        check_ratio(what, "overlap", s, LEAST_OVERLAP_OF_SHEAR)
        w, r = self._w, self._journal_fillet
        return (
            3.0128
            * _polynomial(1.0 - s, 0.4368, 2.1630, -1.5212)
            * (w / (0.0637 + 0.9369 * w))
            * (self._b - 0.5)
            * _power(r, 0.5331, -0.2038)
            * _polynomial(self._d_h, 0.9937, -1.1949, 1.7373)
            * self._recess
        )

    @property
    def beta_torsion(self) -> float:
        """beta_T of the journal's fillet, on the torsional stress of the journal."""
        _ = self._journal_fillet
        return self._torsion(self.web.journal_fillet_radius / self.web.journal_diameter)

    @property
    def gamma_bending(self) -> float:
        """gamma_B of a radial oil hole in the pin, on the bending stress of the pin."""
        return _polynomial(self._oil_hole, 3.0, -5.88, 34.6)

    @property
    def gamma_torsion(self) -> float:
        """gamma_T of a radial oil hole in the pin, on the torsional stress of the pin."""
        return _polynomial(self._oil_hole, 4.0, -6.0, 30.0)

    def at(self, place: str) -> tuple[float, float, float]:
        """Return the factors on bending, shear and torsion at a location; 0 where shear does not count.

        Raises
        ------
        InputError
            If the web has no such location, or the rule no factor.
        """
        if place == "pin fillet":
            return self.alpha_bending, 0.0, self.alpha_torsion
        if place == "journal fillet":
            return self.beta_bending, self.beta_shear, self.beta_torsion
        return self.gamma_bending, 0.0, self.gamma_torsion

    @property
    def _u(self) -> float:
        return 1.0 - max(self.web.ratio("overlap"), LEAST_OVERLAP)

    @property
    def _w(self) -> float:
        return self.web.ratio("web_thickness")

    @property
    def _b(self) -> float:
        return self.web.ratio("web_width")

    @property
    def _d_g(self) -> float:
        return self.web.ratio("journal_bore")

    @property
    def _d_h(self) -> float:
        return self.web.ratio("pin_bore")

    @property
    def _recess(self) -> float:
        deep = self.web.ratio("pin_recess") + self.web.ratio("journal_recess")
        return max(1.0 + deep * (1.8 + 3.2 * self.web.ratio("overlap")), 1.0)

    @property
    def _journal_fillet(self) -> float:
        if self.web.semi_built:
            raise InputError(
                "semi_built: given true; allowed is false for factors of the journal's fillet, because a "
                "shrunk journal has none."
            )
        return self.web.ratio("journal_fillet_radius")

    @property
    def _oil_hole(self) -> float:
        if not self.web.oil_hole_diameter:
            raise InputError(
                "oil_hole_diameter: not given; allowed is that of a radial hole in the pin, because the "
                "factors of its outlet depend on it."
            )
        return self.web.ratio("oil_hole_diameter")

    def _torsion(self, r: float) -> float:
        cubic = DOUBTFUL[self.coefficients][0]
        return (
            0.8
            * _power(r, 1.0, -0.322 + 0.1015 * self._u)
            * _polynomial(self._b, 7.8955, -10.654, 5.3482, -cubic)
            * _power(self._w, 1.0, -0.145)
        )


def coefficient_differences(web: CrankWeb) -> dict[str, float]:
    """Return the relative change of a web's factors from the printed to the suspected coefficients.

    Raises
    ------
    InputError
        If a ratio of the web is outside the range of the formulas.
    """
    printed, suspected = (ConcentrationFactors(web, coefficients) for coefficients in COEFFICIENTS)
    doubted = {"alpha_T": "alpha_torsion"}
    if not web.semi_built:
        doubted |= {"beta_B": "beta_bending", "beta_T": "beta_torsion"}
    return {
        symbol: getattr(suspected, name) / getattr(printed, name) - 1.0
        for symbol, name in doubted.items()
    }


def _polynomial(x: float, *coefficients: float) -> float:
    """Sum the powers of x from the zeroth on."""
    return sum(factor * x**power for power, factor in enumerate(coefficients))


def _power(x: float, factor: float, exponent: float) -> float:
    return factor * math.pow(x, exponent)


SYMBOLS = dict(
    zip(
        FACTORS,
        ("alpha_B", "alpha_T", "beta_B", "beta_Q", "beta_T", "gamma_B", "gamma_T"),
        strict=True,
    )
)


@frozen("alpha_bending", "alpha_torsion", "beta_bending", "beta_shear", "beta_torsion")
class ElementFactors:
    """Factors on the nominal stresses of a web's pin and journal by finite elements (Appendix III, VI).

    Parameters
    ----------
    alpha_bending, alpha_torsion : float or None
        At the pin's fillet: largest equivalent stress by von Mises under a bending moment, largest shear
        stress under a torque. None without a fillet.
    beta_bending, beta_torsion : float or None
        At the journal's fillet.
    beta_shear : float or None
        Method 1: (s_3P - s_N3P beta_B) / s_Q3P of a throw in three-point bending.
    beta_combined : float or None
        Method 2: s_3P / s_N3P, on the bending stress alone.
    gamma_bending, gamma_torsion : float or None
        Largest principal stress at the pin's oil hole, the moment about the axis across the hole. None
        without a hole.
    error : float
        Estimated relative error of the largest stresses.
    as_ruled : bool
        Whether mesh and stresses meet the criteria of Appendix III.
    """

    web: CrankWeb
    alpha_bending: float | None
    alpha_torsion: float | None
    beta_bending: float | None
    beta_shear: float | None
    beta_torsion: float | None
    beta_combined: float | None
    gamma_bending: float | None
    gamma_torsion: float | None
    error: float
    as_ruled: bool

    @property
    def shear_error(self) -> float | None:
        """Estimated relative error of `beta_shear`: `error`, magnified by the difference of stresses."""
        if self.beta_combined is None or self.beta_bending is None:
            return None
        left = abs(self.beta_combined - self.beta_bending)
        return self.error * self.beta_combined / left if left > 0.0 else math.inf

    def at(self, place: str) -> tuple[float, float, float]:
        """Return the factors on bending, shear and torsion at a location; 0 where shear does not count.

        Raises
        ------
        InputError
            If the throw is modeled without that location.
        """
        bending, shear, torsion = {
            "pin fillet": (self.alpha_bending, 0.0, self.alpha_torsion),
            "journal fillet": (self.beta_bending, self.beta_shear, self.beta_torsion),
            "oil hole": (self.gamma_bending, 0.0, self.gamma_torsion),
        }[place]
        if bending is None or shear is None or torsion is None:
            part = "oil_holes" if place == "oil hole" else "fillet_radius"
            raise InputError(
                f"{part}: given none there; allowed is a throw with this {place}, because finite elements "
                "have no factor for what is not meshed."
            )
        return bending, shear, torsion


def unsafe_formulas(
    formulas: ConcentrationFactors | None, elements: ElementFactors | None
) -> dict[str, tuple[float, float]]:
    """Return the factors that are smaller by the rule's formulas than by finite elements: symbol to both."""
    factors: dict[str, tuple[float, float]] = {}
    if formulas is None or elements is None:
        return factors
    for name, symbol in SYMBOLS.items():
        by_elements = getattr(elements, name)
        if by_elements is None:
            continue
        try:
            by_formula = getattr(formulas, name)
        except InputError:
            continue
        if by_formula < by_elements:
            factors[symbol] = by_formula, by_elements
    return factors


# K_e: what neighboring throws take of the bending of one that is supported by itself.
BENDING_SHARE = {2: 0.8, 4: 1.0}
# Directions among which the worst of an oil hole is looked for, half a turn [deg].
DIRECTIONS_DEG = np.arange(0.0, 180.0)


@frozen("length [m]", "rods [m]", eq=False)
class SupportedThrow:
    """One throw on two supports, the middles of its main journals: statically determinate.

    Parameters
    ----------
    length : float
        L_3, between the supports [m].
    rods : (n,) array_like
        Position of each rod from the left support [m], L_2.
    radial, tangential : (n, m) array_like
        Force of each rod on the pin over one cycle, towards the shaft and in the sense of rotation [N].

    Raises
    ------
    InputError
        If there are no forces for each rod, or one is not between the supports.
    """

    length: float
    rods: ArrayLike
    radial: ArrayLike
    tangential: ArrayLike

    def __post_init__(self) -> None:
        span = positive_number("length", self.length, "m", "the supports are apart")
        rods = finite_vector("rods", self.rods)
        object.__setattr__(self, "rods", rods)
        if rods.size == 0 or np.any(rods <= 0.0) or np.any(rods >= span):
            raise InputError(
                f"rods: given {rods.tolist()} m; allowed are places above 0 and below {span:g} m, "
                "because rods stand between the supports."
            )
        for name in ("radial", "tangential"):
            forces = finite_array(name, getattr(self, name))
            if forces.ndim != 2 or forces.shape[0] != rods.size or forces.shape[1] == 0:
                raise InputError(
                    f"{name}: given an array of shape {forces.shape}; allowed is ({rods.size}, m), because "
                    "each rod has a force at each angle of the cycle."
                )
            object.__setattr__(self, name, forces)

    def moment(self, at: float, force: ArrayLike) -> Array:
        """Return the bending moment at a distance from the left support, of forces as `radial` [N m], (m,).

        Raises
        ------
        InputError
            If the distance is not a finite number, or there are no forces for each rod.
        """
        rods, forces = self._checked(at, force)
        left = (self.length - rods) / self.length @ forces
        return np.asarray(left * at - np.maximum(at - rods, 0.0) @ forces)

    def shear(self, at: float, force: ArrayLike) -> Array:
        """Return the shear force at a distance from the left support [N], (m,); otherwise as `moment`."""
        rods, forces = self._checked(at, force)
        left = (self.length - rods) / self.length @ forces
        return np.asarray(left - (rods < at).astype(float) @ forces)

    def _checked(self, at: float, force: ArrayLike) -> tuple[Array, Array]:
        """Return the rods and the forces on them, checked with the position of the section."""
        nonnegative_number("at", at, "m", "it is counted from the left support")
        rods, forces = np.asarray(self.rods), finite_array("force", force)
        check_shape("force", forces, (rods.size, *forces.shape[1:]))
        return rods, forces


def alternating(values: ArrayLike) -> Array:
    """Return half of the distance from the lowest to the highest value over the last axis.

    Raises
    ------
    InputError
        If a value is not finite, or there is none over the last axis.
    """
    series = finite_array("values", values)
    if series.ndim == 0 or series.shape[-1] == 0:
        raise InputError(
            f"values: given an array of shape {series.shape}; allowed is a value or more over the last axis, "
            "because they alternate between the lowest and the highest."
        )
    return np.asarray(0.5 * np.ptp(series, axis=-1))


def web_stresses(
    throw: SupportedThrow, web: CrankWeb, at: float, *, strokes: int
) -> tuple[float, float]:
    """Return the nominal alternating stresses of a web due to the radial forces [Pa].

    Parameters
    ----------
    at : float
        Middle of the web's thickness from the left support [m]; L_1 of the left web.
    strokes : {2, 4}

    Returns
    -------
    bending : float
        s_BFN = M / (B W^2 / 6) K_e.
    shear : float
        s_QFN = Q / (B W) K_e, with K_e = 0.8 of two-stroke and 1 of four-stroke engines.

    Raises
    ------
    InputError
        If strokes are others.
    """
    checked_strokes(strokes)
    share, area = BENDING_SHARE[strokes], web.web_width * web.section_thickness
    moment = float(alternating(throw.moment(at, throw.radial)))
    shear = float(alternating(throw.shear(at, throw.radial)))
    return share * moment / web.bending_modulus, share * shear / area


def hole_stress(
    throw: SupportedThrow, web: CrankWeb, at: float, angle_deg: float | None = None
) -> float:
    """Return the nominal alternating bending stress of the pin at an oil hole's outlet [Pa].

    Parameters
    ----------
    web : CrankWeb
        Of the pin.
    at : float
        Position of the hole from the left support [m].
    angle_deg : float, optional
        psi: of the outlet from the direction in which the pin moves, positive away from the shaft [deg];
        by default the direction with the largest stress.

    Notes
    -----
    M_BO = M_BTO cos(psi) + M_BRO sin(psi) over pi/32 (D^4 - D_BH^4) / D. A force bends the pin in its
    own direction; the radial force points to the shaft, so it counts as negative in M_BRO.
    """
    check_kind("throw", throw, SupportedThrow, "a SupportedThrow")
    check_kind("web", web, CrankWeb, "a CrankWeb")
    directions = DIRECTIONS_DEG if angle_deg is None else finite_array("angle_deg", [angle_deg])
    psi = np.radians(directions)
    moments = np.outer(np.cos(psi), throw.moment(at, throw.tangential)) - np.outer(
        np.sin(psi), throw.moment(at, throw.radial)
    )
    modulus = 0.5 * float(section_modulus("torsional", web.pin_diameter, web.pin_bore))
    return float(np.max(alternating(moments))) / modulus
