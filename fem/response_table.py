"""Names, symbols, units and meanings of the responses of a throw, which are read without finite elements."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from crankbase.table import text_rows


@dataclass(frozen=True)
class ResponseKind:
    """A response: its symbol, SI unit ("" for a plain number) and meaning."""

    symbol: str
    unit: str
    meaning: str


# Name | symbol | unit | meaning.
_RESPONSES = """
axial_compliance_pinned | e_n | m/N | axial compliance, ends pinned
axial_compliance_guided | e_g | m/N | axial compliance, ends guided
axial_compliance_opposite | e_180 | m/N | axial compliance between opposite neighbors, 180 deg
axial_compliance_in_line | e_0 | m/N | axial compliance between neighbors in line, 0 deg
tilt_stiffness_ratio | rho | | tilt stiffness across the crank plane divided by that in it
torsional_compliance_pinned | e_t | rad/(N m) | torsional compliance, ends pinned
torsional_compliance_guided | e_tg | rad/(N m) | torsional compliance, ends guided
influence_coefficient_pinned | c | m/N | lengthening per unit radial force on the pin, ends pinned
influence_coefficient_guided | c_g | m/N | lengthening per unit radial force on the pin, ends guided
influence_coefficient_opposite | c_180 | m/N | influence coefficient between opposite neighbors, 180 deg
influence_coefficient_in_line | c_0 | m/N | influence coefficient between neighbors in line, 0 deg
axial_reaction_pinned | P/Z | | axial reaction per unit radial force on the pin, length kept, ends pinned
axial_reaction_guided | P_g/Z | | axial reaction per unit radial force on the pin, length kept, ends guided
radial_end_moment_left_guided | m_Zl | | end moment (-x) per radial force and length, left end, ends guided
radial_end_moment_right_guided | m_Zr | | end moment (+x) per radial force and length, right end, ends guided
axial_end_moment_left_guided | m_Nl | | end moment (-x) per axial force and length, left end, ends guided
axial_end_moment_right_guided | m_Nr | | end moment (+x) per axial force and length, right end, ends guided
tangential_end_moment_opposed_guided | m_To | | half difference of end moments (y) per tangential force and \
length, guided
tangential_end_moment_alike_guided | m_Ta | | half sum of end moments (y) per tangential force and length, \
guided
radial_end_moment_in_line | m_Z0 | | end moment (-x) per radial force and length, left end, neighbors in line
axial_end_moment_in_line | m_N0 | | end moment (-x) per axial force and length, left end, neighbors in line
tangential_end_moment_in_line | m_T0 | | half difference of end moments (y), as m_To, neighbors in line
tangential_end_moment_opposite | m_T180 | | half sum of end moments (y), as m_Ta, neighbors opposite, 180 deg
cross_tilt_stiffness_ratio | rho_x | | as rho, both ends tilting alike in the crank plane, against each \
other across
mass | m | kg | mass
fillet_stress_factor | k_s | | largest stress concentration factor at the fillets, under bending in the \
crank plane and under torque
"""

RESPONSES: Mapping[str, ResponseKind] = MappingProxyType(
    {name: ResponseKind(*cells) for name, *cells in text_rows(_RESPONSES)}
)
