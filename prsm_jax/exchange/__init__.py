"""Files of other programs: drawings, workbooks, histories, and tables of profiles, in and out."""

from ._drawing import write_dxf as write_dxf
from ._results import export_result as export_result
from ._tables import (
    read_duty_cycle as read_duty_cycle,
    read_scenario as read_scenario,
    write_duty_cycle as write_duty_cycle,
    write_measurements as write_measurements,
    write_scenario as write_scenario,
)
from ._workbook import write_workbook as write_workbook
from .fmu import write_fmu as write_fmu
from .step import (
    BodyMassRule as BodyMassRule,
    SolidMass as SolidMass,
    StepBody as StepBody,
    solid_mass as solid_mass,
    solid_volume as solid_volume,
    write_step as write_step,
)
