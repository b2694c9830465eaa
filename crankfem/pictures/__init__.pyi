"""Public names of this topic and their homes."""

from crankfem.analyses.mechanism.plots import plot_accelerations as plot_accelerations
from crankfem.analyses.mechanism.plots import plot_balance as plot_balance
from crankfem.analyses.mechanism.plots import plot_hinged_rods as plot_hinged_rods
from crankfem.analyses.mechanism.plots import plot_polar_loads as plot_polar_loads
from crankfem.analyses.throw.pictures.solid_picture import picture_shaft as picture_shaft
from crankfem.analyses.throw.pictures.solid_picture import picture_throw as picture_throw
from crankfem.analyses.throw.pictures.stress_picture import picture_stresses as picture_stresses
from crankfem.analyses.vibration.plots import plot_response_campbell as plot_response_campbell
from crankfem.analyses.vibration.plots import plot_transient as plot_transient
from crankfem.analyses.vibration.plots import plot_transient_over_speed as plot_transient_over_speed
