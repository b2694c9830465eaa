"""Spellings of units as people write them: each kind of field reads those of its own, and refuses all others.

Sizes are from the definitions: the yard and pound of 1959, and the standard acceleration of free fall.
"""

import math
import pkgutil
import re
from importlib import import_module

import pytest

import crankfem.files
import crankfem.satellites
from comparing import close
from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra
from crankbase.units import unit_registry
from crankbase.written_quantity import parse_quantity
from dynamics.chains.varying import Variation

G, LB, INCH, FT = 9.80665, 0.45359237, 0.0254, 0.3048
LBF, TURN, DEG = LB * G, 2 * math.pi, math.pi / 180
PSI, AT = LBF / INCH**2, G * 1e4

# Spellings of each size, by the SI unit of the fields that read them.
RATES = {
    1: "Hz | Гц | hertz | 1/s | s-1 | s^-1 | s⁻¹ | 1/с | /s | 1 / s | rps | rev/s | r/s | U/s"
    " | turn/s | turns/s | c/s"
    " | cps | cycle/s | cycles/s | cycle/second | revolutions per second | об/с | rev s-1 | 1/sec",
    1e3: "kHz | кГц | kilohertz",
    1 / 60: "1/min | min-1 | min^-1 | min⁻¹ | 1 / min | /min | rpm | RPM | r.p.m. | r.p.m | r/min"
    " | rev/min | revs/min"
    " | rev / min | U/min | U / min | Upm | UpM | tr/min | obr/min | об/мин | об/мин. | turn/min"
    " | cpm | c/min"
    " | cycles/min | cycles per minute | revolutions per minute | rev min-1 | rev·min⁻¹ | 1/мин | мин⁻¹",
    1 / 3600: "1/h | rev/h",
    1 / TURN: "rad/s | рад/с | rad s-1 | rad·s⁻¹ | rad s^-1 | radian/second | radians per second",
    1 / 360: "deg/s | °/s | degree/s | degrees per second",
    1 / 400: "gon/s",
    1 / 21600: "arcmin/s | deg/min | °/min",
}
SPELLINGS = {
    "Hz": RATES,
    "rad/s": {TURN * size: words for size, words in RATES.items()},
    "N": {
        1: "N | Н | newton | newtons | kg m/s2 | kg·m/s² | kg m s-2 | J/m",
        1e3: "kN | кН | kilonewton",
        1e6: "MN | МН | meganewton",
        1e9: "GN",
        1e-3: "mN",
        10: "daN | даН",
        1e-5: "dyn",
        G: "kgf | kp | kG | кГ | кгс | kg | кг | kilogram",
        G / 1e3: "gf | гс | g | г",
        G * 1e3: "tf | тс | Mp | t | т | tonne | tonnes",
        LBF: "lbf | lb | lbs | lbs. | pound | pounds",
        1e3 * LBF: "kip | kips | klbf",
        LBF / 16: "ozf | oz",
    },
    "kg": {
        1: "kg | кг | kilogram | kilograms | kg. | N s2/m",
        1e-3: "g | г | gram | grams",
        1e3: "t | т | Mg | tonne | tonnes",
        1e-6: "mg | мг",
        LB: "lb | lbs | lbs. | lbm | pound | pounds",
        LB / 16: "oz | ounce",
        2000 * LB: "short_ton",
        2240 * LB: "long_ton",
        LBF / FT: "slug | slugs | lbf s2/ft",
        LBF / INCH: "lbf s2/in | lb s2/in | lb-s2/in",
        G: "kgf s2/m | kp·s²/m | кгс·с²/м",
    },
    "m": {
        1: "m | м | meter | metre | metres",
        1e-3: "mm | мм | mm. | millimetre | millimeters | ㎜",
        1e-2: "cm | см | centimeter",
        0.1: "dm | дм",
        1e3: "km | км",
        1e-6: "um | µm | μm | мкм | micron | microns | micrometer",
        1e-9: "nm",
        INCH: "in | in. | inch | inches",
        FT: "ft | ft. | foot | feet",
        INCH / 1e3: "mil | mils | thou",
    },
    "m^2": {
        1: "m^2 | m2 | m² | m**2 | м² | м2 | meter**2 | m m",
        1e-6: "mm^2 | mm2 | mm² | qmm | мм² | mm^ 2",
        1e-4: "cm^2 | cm2 | cm² | qcm | см²",
        1e-2: "dm^2 | dm2 | dm²",
        INCH**2: "in^2 | in2 | in²",
        FT**2: "ft2 | ft²",
    },
    "kg/m^3": {
        1: "kg/m^3 | kg/m3 | kg/m³ | кг/м³ | кг/м3 | kg m^-3 | kg m-3 | kg·m⁻³ | kg per m^3 | g/l | g/L",
        1e3: "g/cm^3 | g/cm3 | g/cm³ | г/см³ | g/cc | g/ccm | kg/dm3 | kg/dm³ | kg/l | kg/L"
        " | t/m3 | т/м³ | g cm-3",
        LB / INCH**3: "lb/in3 | lb/in^3 | lbm/in³",
        LB / FT**3: "lb/ft3 | lbm/ft^3",
        LBF / FT / FT**3: "slug/ft3",
    },
    "s": {
        1: "s | с | sec | sec. | second | seconds",
        1e-3: "ms | мс | millisecond",
        1e-6: "us | µs",
        60: "min | мин | minute | minutes",
        3600: "h | ч | hr | hours",
    },
    "rad": {
        1: "rad | рад | radian | radians",
        1e-3: "mrad | мрад | milliradian",
        1e-6: "urad | µrad",
        DEG: "deg | ° | º | degree | degrees | degs | deg. | deg CA | °CA | degCA | °KW | °ПКВ"
        " | CAD | ° CA",
        TURN: "turn | turns | rev | revolution | revolutions",
        TURN / 400: "gon",
        DEG / 60: "arcmin",
        DEG / 3600: "arcsec",
    },
    "Pa": {
        1: "Pa | Па | pascal | N/m2 | N/m^2 | N/m² | Н/м²",
        1e3: "kPa | кПа | kilopascal | kN/m2 | kPa(a) | kPa abs | kPaA",
        1e6: "MPa | МПа | megapascal | N/mm2 | N/mm^2 | N/mm² | Н/мм² | MN/m² | MPa(abs) | MPaA | J/cm3",
        1e9: "GPa | ГПа | kN/mm2 | kN/mm² | gigapascal",
        1e2: "hPa | mbar | mbar(a) | hPa(a) | hPa abs",
        1e5: "bar | бар | bara | bar(a) | bar a | bar abs | bar(abs) | bar absolute | bar_a | bar A",
        AT: "at | ат | ata | ата | kgf/cm2 | kgf/cm² | kp/cm2 | kp/cm² | kg/cm2 | kg/cm²"
        " | кгс/см² | кгс/см2 | кГ/см²"
        " | kG/cm2 | kg/cm2 a | kgf/cm2(abs)",
        1e2 * AT: "kgf/mm2 | kp/mm² | kg/mm² | кгс/мм²",
        1e3 * AT: "t/cm2 | tf/cm2 | т/см²",
        101325: "atm | атм",
        101325 / 760: "Torr | torr",
        13595.1 * G * 1e-3: "mmHg",
        PSI: "psi | psia | psi(a) | psi abs | lbf/in2 | lbf/in² | lb/in2 | lb/in^2",
        1e3 * PSI: "ksi | kpsi | kip/in2 | klbf/in2",
        LBF / FT**2: "lbf/ft2 | lb/ft2",
    },
    "W": {
        1: "W | Вт | watt | watts | J/s | N m/s | Nm/s",
        1e3: "kW | кВт | kilowatt | kJ/s | kN m/s | kNm/s",
        1e6: "MW | МВт | megawatt",
        75 * G: "PS | CV | л.с. | л.с | лс",
        550 * FT * LBF: "hp",
        FT * LBF: "ft lbf/s | ft-lb/s | lbf ft/s",
        G: "kgf m/s | kp m/s | kpm/s | kg m/s | kgm/s | кгс·м/с | mkp/s",
        1055.056 / 3600: "BTU/h | Btu/hr",
    },
    "N m": {
        1: "N m | Nm | N.m | N-m | N·m | N⋅m | N•m | N*m | N×m | Н·м | Нм | Н м | J | kg m2/s2"
        " | newton meter | N\u00a0m",
        1e3: "kN m | kNm | kN-m | kN.m | kN·m | kN*m | кНм | кН·м | kJ",
        1e6: "MN m | MNm | МНм | MN·m",
        1e-3: "N mm | Nmm | N·mm | mNm | mN m | mN·m",
        1e-2: "N cm | Ncm | N·cm",
        10: "daN m | daNm",
        G: "kgf m | kgfm | kgf-m | kgf·m | kp m | kpm | kp·m | mkp | kg m | kgm | kg-m | mkg"
        " | m·kg | кгс·м | кГ·м | кгс м",
        G * 1e3: "t m | tm | tf m | tf·m | Mp m | Mpm | тс·м",
        G / 1e2: "kgf cm | kgfcm | kg cm | kgcm | kp cm | kpcm | кгс·см",
        FT * LBF: "lbf ft | ft lbf | lb-ft | ft-lb | ft.lb | lb·ft | lb ft | ftlb | lbft | ft-lbs"
        " | ft*lbf | lbfft",
        INCH * LBF: "lbf in | in lbf | lb-in | in-lb | inlb | lbin | lb in | in-lbs",
        INCH * LBF / 16: "oz-in | ozf in | ozin | inoz",
    },
    "N m/rad": {
        1: "N m/rad | Nm/rad | N.m/rad | N-m/rad | N·m/rad | Н·м/рад | Нм/рад | N m rad^-1"
        " | Nm·rad-1 | Nm·rad⁻¹ | Nm / rad"
        " | N m per rad | (N m)/rad | J/rad | Nm/radian",
        1e3: "kN m/rad | kNm/rad | kN.m/rad | kN·m/rad | кН·м/рад | кНм/рад | kNm / rad"
        " | kN-m/rad | Nm/mrad",
        1e6: "MN m/rad | MNm/rad | MN·m/rad | МН·м/рад | kNm/mrad",
        1e-3: "Nmm/rad | N mm/rad | mNm/rad",
        1 / DEG: "N m/deg | Nm/deg | N m/° | Nm/° | N·m/degree | Н·м/°",
        1e3 / DEG: "kN m/deg | kNm/deg | kNm/°",
        G: "kgf m/rad | kgfm/rad | kp m/rad | kpm/rad | kg m/rad | kgm/rad | кгс·м/рад | mkp/rad",
        G / 1e2: "kgf cm/rad | kgfcm/rad | kg cm/rad | kp cm/rad | кгс·см/рад",
        INCH * LBF: "lbf in/rad | lb in/rad | lb-in/rad | in-lb/rad | in lbf/rad | in.lbf/rad",
        FT * LBF: "lbf ft/rad | ft lbf/rad | lb-ft/rad | ft-lb/rad",
        INCH * LBF / DEG: "lbf in/deg | in-lb/deg | lb-in/°",
        1 / TURN: "N m/rev | Nm/turn",
    },
    "N m s/rad": {
        1: "N m s/rad | Nms/rad | Nm s/rad | Nm·s/rad | N·m·s/rad | N.m.s/rad | N-m-s/rad"
        " | N m/(rad/s) | Nm/(rad/s) | N m s"
        " | Nms | N·m·s | J s | Js | J s/rad | Nms rad^-1 | Nm·s·rad-1 | Нм·с/рад | Н·м·с/рад"
        " | Нмс/рад | Н·м·с | kg m2/s",
        1e3: "kN m s/rad | kNms/rad | kNm s/rad | kNm·s/rad | kN·m·s/rad | кН·м·с/рад | kNms"
        " | kNm s | kN·m·s"
        " | kN m/(rad/s) | kNm/(rad/s)",
        1e6: "MN m s/rad | MNms/rad | MN·m·s/rad | MNm·s",
        1e-3: "N mm s/rad | Nmm s/rad | Nmms/rad | mN m s/rad | mNms/rad | Nm ms/rad",
        G: "kgf m s/rad | kp m s/rad | kpms/rad | kgf·m·s | kgfms | kg m s | kp·m·s | кгс·м·с/рад"
        " | кгс·м·с",
        G / 1e2: "kgf cm s/rad | kg cm s | кгс·см·с",
        INCH * LBF: "lbf in s/rad | lb in s/rad | lb-in-s/rad | lb-in-s | in-lb-s/rad",
        FT * LBF: "lbf ft s/rad | lb-ft-s/rad | ft lbf s",
        1 / DEG: "N m s/deg | Nms/deg | Nms/° | Nm/(deg/s) | Nm/(°/s)",
        60 / TURN: "N m/rpm | Nm/rpm | Nm/(rev/min) | Nm/(turn/min)",
    },
    "N s/m": {
        1: "N s/m | Ns/m | N·s/m | N.s/m | N-s/m | N*s/m | N/(m/s) | kg/s | Н·с/м | Нс/м"
        " | N s m^-1 | N s m-1 | N·s·m⁻¹ | Ns / m",
        1e3: "kN s/m | kNs/m | kN·s/m | kN.s/m | kN/(m/s) | кН·с/м | Ns/mm | N s/mm | N·s/mm"
        " | N/(mm/s) | кНс/м | t/s",
        1e6: "MN s/m | MNs/m | MN·s/m | MN/(m/s) | kNs/mm | kN s/mm | kN/(mm/s) | МН·с/м",
        1e2: "N s/cm | Ns/cm",
        G: "kgf s/m | kp s/m | kg s/m | kps/m | кгс·с/м | kgfs/m",
        G * 1e2: "kgf s/cm | kg s/cm | kp·s/cm | кгс·с/см",
        G * 1e3: "kgf s/mm | kg s/mm | tf s/m | t s/m",
        LBF / INCH: "lbf s/in | lb s/in | lb-s/in | lbf-s/in | lbf/(in/s) | lb·s/in",
        LBF / FT: "lbf s/ft | lb-s/ft | slug/s",
        LB: "lbm/s | lb/s",
    },
    "N/m": {
        1: "N/m | Н/м | N m^-1 | N m-1 | N·m⁻¹ | N / m | N per m | kg/s2 | J/m2",
        1e3: "kN/m | кН/м | N/mm | Н/мм | N mm-1 | N/millimetre | t/s2",
        1e6: "MN/m | МН/м | kN/mm | кН/мм | N/um | N/µm | N/мкм | kN mm^-1",
        1e9: "GN/m | MN/mm | МН/мм | kN/um | kN/µm",
        1e2: "N/cm",
        1e5: "kN/cm",
        G: "kgf/m | kp/m | kg/m | кгс/м",
        G * 1e2: "kgf/cm | kp/cm | kg/cm | кгс/см",
        G * 1e3: "kgf/mm | kp/mm | kg/mm | кгс/мм | tf/m | t/m",
        G * 1e5: "tf/cm | t/cm | тс/см",
        G * 1e6: "tf/mm | t/mm | Mp/mm",
        LBF / INCH: "lbf/in | lb/in | lb/in. | lbs/inch",
        1e3 * LBF / INCH: "kip/in | klbf/in",
        LBF / FT: "lbf/ft | lb/ft",
        LBF * 1e3 / INCH: "lbf/mil | lb/thou",
    },
    "kg m^2": {
        1: "kg m^2 | kg m2 | kg m² | kgm2 | kgm^2 | kgm² | kg·m² | kg·m2 | kg*m2 | kg*m^2 | kg.m2"
        " | kg-m2 | kg-m^2 | kg×m²"
        " | kg⋅m² | kg m**2 | кг·м² | кг м2 | кгм² | кг·м2 | m2 kg | N m s2 | Nms2",
        1e3: "t m2 | t·m² | tm2 | kN m s2 | т·м² | t m^2 | Mg m2",
        1e-4: "kg cm2 | kg cm^2 | kgcm2 | kg·cm² | kgcm² | кг·см²",
        1e-6: "kg mm2 | kgmm2 | kg·mm² | kg mm^2",
        1e-7: "g cm2 | gcm2 | g·cm² | gcm²",
        G: "kgf m s2 | kgf·m·s² | kp m s2 | kpms2 | kp·m·s² | kg m s2 | кгс·м·с² | kgfms²",
        G / 1e2: "kgf cm s2 | kgf·cm·s² | kg cm s2 | кгс·см·с²",
        LB * FT**2: "lb ft2 | lb-ft2 | lb ft^2 | lb·ft² | lbm ft2 | lbm-ft²",
        LB * INCH**2: "lb in2 | lb-in2 | lb in^2 | lbm in²",
        LBF * INCH: "lb in s2 | lbf in s2 | lb-in-s2 | lbf-in-s^2 | in-lb-s2",
        LBF * FT: "lbf ft s2 | lb-ft-s2 | slug ft2 | slug-ft2",
        LB / 16 * INCH**2: "oz in2 | oz-in2",
    },
    "m/N": {
        1: "m/N | м/Н | m N^-1 | 1/(N/m) | m/newton",
        1e-3: "mm/N | мм/Н | m/kN | м/кН | mm N-1 | 1/(N/mm)",
        1e-6: "um/N | µm/N | μm/N | mm/kN | мм/кН | мкм/Н | m/MN | 1/(kN/mm)",
        1e-9: "um/kN | µm/kN | nm/N | мкм/кН | m/GN | mm/MN | 1/(MN/mm)",
        1e-2: "cm/N",
        1e-5: "cm/kN",
        1e-12: "um/MN | µm/MN",
        1 / G: "m/kgf | м/кгс | m/kg",
        1e-2 / G: "cm/kgf | cm/kg | см/кгс | cm/kp",
        1e-3 / G: "mm/kgf | mm/kg | mm/kp | мм/кгс",
        1e-6 / G: "mm/t | mm/tf | мм/тс | um/kgf | µm/kgf",
        INCH / LBF: "in/lbf | in/lb | inch/lbf",
        1e-3 * INCH / LBF: "in/kip | in/klbf | mil/lbf | thou/lbf",
        FT / LBF: "ft/lbf | ft/lb",
    },
    "rad/(N m)": {
        1: "rad/(N m) | rad/Nm | rad/(Nm) | rad/(N·m) | рад/(Н·м) | рад/Нм | rad/J | 1/Nm"
        " | 1/(N m) | rad N^-1 m^-1"
        " | rad·(N m)^-1 | 1/(Nm/rad)",
        1e-3: "rad/(kN m) | rad/kNm | rad/(kNm) | mrad/Nm | mrad/(N m) | рад/(кН·м) | мрад/(Н·м) | 1/kNm",
        1e-6: "mrad/kNm | mrad/(kN m) | rad/MNm | rad/(MN m) | urad/Nm | µrad/Nm | мрад/(кН·м)",
        1e-9: "urad/kNm | urad/(kN m) | µrad/kNm",
        DEG: "deg/Nm | deg/(N m) | °/Nm | °/(N m) | deg/(N·m)",
        DEG / 1e3: "deg/kNm | deg/(kN m) | °/kNm",
        1 / G: "rad/(kgf m) | rad/kgfm | rad/(kp m) | rad/(kg m) | рад/(кгс·м)",
        1e2 / G: "rad/(kgf cm) | rad/(kg cm) | 1/(kgf cm) | рад/(кгс·см)",
        1 / LBF / INCH: "rad/(lbf in) | rad/(in lbf) | rad/(lb-in) | rad/lbin",
        1 / LBF / FT: "rad/(lbf ft) | rad/(ft-lb)",
        DEG / LBF / FT: "deg/(ft lbf)",
    },
}
# A base of values per unit is an apparent power; no other field takes one.
SPELLINGS["VA"] = SPELLINGS["W"] | {
    size: f"{SPELLINGS['W'][size]} | {unit}"
    for size, unit in ((1, "VA"), (1e3, "kVA"), (1e6, "MVA"))
}
# Temperatures with a zero of their own: 20 of each [K].
TEMPERATURES = {
    293.15: "degC | deg C | degrees C | deg. C | °C | ° C | ℃ | C | celsius | Celsius | °С",
    (20 + 459.67) / 1.8: "degF | deg F | degree F | °F | F | fahrenheit | Fahrenheit",
    20.0: "K | kelvin | Kelvin | °K | degK",
}
# What nobody can know the size of, or the field cannot hold: refused in every field.
REFUSED = """
    ton tons kt kgs bhp shp mhp ihp grad Grad град grads кгсм T S Mm mPa mW NM KN KW Kg Mpa KPa HZ hz
    Mhz KNm kNM Kgm2 bar(g) barg bar_g barü bar(ü) bar_gauge BAR psig psi(g) psi_g atü atu ати kgf/cm2_g
    kg/cm2(g) kPa(g) kPag MPaG MPa(g) % ‰ ppm dB ' " ″ ′ # $ € ? m^0 kg^0 mmm xyz furlong smoot parsek
    1_mm 1.0_mm mm_1 mm/1 1/1_mm 1_1/min 1_N 1_kg 1_N_m/rad
    ohm A V mol cd eV Bq baud bit nan inf e5 x 2m kgf_m2 kgf·m² kp_m2 kpm2 кгс·м² Nm2 N_m2 GD2 lbf_ft2
    BTDC deg_BTDC deg_ATDC N_m/rad/s N/m/s rad/N_m N_m_min N_m/(1/min) N_m/Hz rad^2 deg2/s 1/min^2
    rad/s2 mm²/s Nm/rad2 m//s m/ (m ** °C/s N_m/degC K/W degC_m 1/K -1 +mm mm-mm2- 10^3_N ·10³_Nm e
"""


def _sizes():
    """Return what 2 of each spelling is, by unit of the field."""
    values = {
        unit: {word.strip(): 2 * size for size, words in sizes.items() for word in words.split("|")}
        for unit, sizes in SPELLINGS.items()
    }
    # Units of mass are weights in a field of forces.
    no_weight = ("Mg", "mg", "мг", "slug", "ton", "s2", "s²", "с²")
    values["N"] |= {
        word: G * size
        for word, size in values["kg"].items()
        if not any(part in word for part in no_weight)
    }
    # The radian of a torsional stiffness, and it alone, may be left out.
    values["N m/rad"] = values["N m"] | values["N m/rad"]
    values["K"] = {
        word.strip(): size for size, words in TEMPERATURES.items() for word in words.split("|")
    }
    return values


VALUES = _sizes()
ALL = {word for values in VALUES.values() for word in values} | {
    word.replace("_", " ") if word not in ("short_ton", "long_ton") else word
    for word in REFUSED.split()
}


def _number(unit):
    return 20 if unit == "K" else 2


def _kinds(record=InputModel):
    for kind in record.__subclasses__():
        yield from (field_extra(info, "unit") for info in kind.model_fields.values())
        yield from _kinds(kind)


@pytest.mark.slow
def test_each_kind_of_field_is_here():
    for package in (crankfem.files, crankfem.satellites):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            import_module(module.name)
    assert {*_kinds()} - {None, ""} == {*VALUES}
    assert len(ALL) > 60


@pytest.mark.parametrize("unit", VALUES)
def test_what_is_meant_is_read(unit):
    values = VALUES[unit]
    number = _number(unit)
    read = [parse_quantity(f"{number} {word}", unit, "field") for word in values]
    assert read == close([*values.values()], rel=3e-6 if unit == "Pa" else 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("unit", VALUES)
def test_what_means_something_else_is_refused_with_what_can_be_read(unit):
    misread, refusals = {}, []
    for word in sorted(ALL - {*VALUES[unit]}):
        try:
            misread[word] = parse_quantity(f"{_number(unit)} {word}", unit, "field")
        except InputError as error:
            refusals.append(str(error))
    assert misread == {}
    for refusal in refusals:
        assert refusal.startswith("field: given ")
        for suggested in re.findall(r'"([^"]*)"', refusal.partition(";")[2]):
            parse_quantity(suggested, unit, "field")


@pytest.mark.parametrize("unit", VALUES)
def test_a_decimal_comma_is_suggested_as_a_point_with_the_same_unit(unit):
    for word in [*VALUES[unit]][:5]:
        with pytest.raises(InputError) as caught:
            parse_quantity(f"1,5 {word}", unit, "field")
        (suggested,) = re.findall(r'"([^"]*)"', str(caught.value))
        assert suggested == f"1.5 {word}"


@pytest.mark.parametrize("text", ["-300 degC", "-274 °C", "-460 degF", "-1 K"])
def test_no_temperature_is_below_absolute_zero(text):
    with pytest.raises(InputError, match="below absolute zero"):
        parse_quantity(text, "K", "field")


@pytest.mark.parametrize("text", ["40 kgf m2", "40 kp·m²", "40 кгс·м²", "392.266 N m2"])
def test_the_inertia_of_a_flywheel_effect_is_suggested(text):
    # G D^2 by weight in kgf m2 is as many kg m^2 by mass; J is a quarter of that.
    with pytest.raises(InputError) as caught:
        parse_quantity(text, "kg m^2", "field")
    assert re.findall(r'"([^"]*)"', str(caught.value)) == ["10 kg m^2", "40 kg m^2"]


def test_a_temperature_of_rubber_is_not_one_of_cold_gases():
    # 50 K is meant as 50 degC.
    with pytest.raises(InputError, match="did you mean 50 degC"):
        Variation.from_text({"speed": ["0 1/min"], "stiffness": [1.0], "at_temperature": "50 K"})
    with pytest.raises(InputError, match="allowed are 150 K to 700 K"):
        Variation(temperature=(20.0, 80.0), stiffness=(1.0, 0.8), at_temperature=300.0)


def test_frequencies_of_a_table_are_the_same_in_any_unit():
    written = ["20 Hz", "1200 rpm", "1200 1/min", "7200 deg/s", "20 rev/s", f"{20 * TURN!r} rad/s"]
    values = {"frequency": ["0 Hz", "20 Hz"], "stiffness": [1.0, 1.2]}
    for text in written:
        read = Variation.from_text(values | {"frequency": ["0 Hz", text]})
        assert read.frequency == close((0.0, 20.0), rel=1e-14)


def test_nothing_of_pint_is_defined_anew(caplog):
    """Which it would log, in the service's log too."""
    unit_registry.__wrapped__()
    assert caplog.records == []
