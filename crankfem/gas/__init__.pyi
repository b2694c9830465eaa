"""Public names of this topic and their homes."""

from dynamics.engine.forces import gas_forces as gas_forces
from dynamics.gas.gas_cycle import GasCycle as GasCycle
from dynamics.gas.gas_cycle import GasCycleResult as GasCycleResult
from dynamics.gas.gas_cycle import gas_cycle as gas_cycle
from dynamics.gas.gas_cycle import usual_gas_cycle as usual_gas_cycle
from dynamics.gas.pressure import GasPressure as GasPressure
from dynamics.gas.pressure import gas_pressure as gas_pressure
from dynamics.gas.pressure import indicated_work as indicated_work
from dynamics.gas.pressure import read_pressure_table as read_pressure_table
from dynamics.sample_tables import TableReading as TableReading
