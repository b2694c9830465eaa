"""Public names of this topic and their homes."""

from crankfem.satellites.measured.measured_orders import MeasuredOrders as MeasuredOrders
from crankfem.satellites.measured.measurement import Measurement as Measurement
from crankfem.satellites.measured.measurement import load as load
from crankfem.satellites.measured.overlay import Overlay as Overlay
from crankfem.satellites.measured.overlay import overlay as overlay
from crankfem.satellites.measured.pulses import pulse_times as pulse_times
from crankfem.satellites.measured.records.reading import read_record as read_record
from crankfem.satellites.measured.records.top import cylinder_pressure as cylinder_pressure
from crankfem.satellites.measured.wheel import Wheel as Wheel
from crankfem.satellites.measured.wheel_constants import (
    constants_by_reference as constants_by_reference,
)
from crankfem.satellites.measured.wheel_constants import edge_disagreement as edge_disagreement
from crankfem.satellites.measured.wheel_constants import without_wheel as without_wheel
