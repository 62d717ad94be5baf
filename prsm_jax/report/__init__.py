"""Pictures and reports for engineers: millimetres, rpm, kilonewtons, megapascals, degrees."""

from ._campbell_chart import campbell_chart as campbell_chart
from ._contact_ellipses import contact_ellipses as contact_ellipses
from ._contact_pictures import (
    contact_pictures as contact_pictures,
    save_contact_pictures as save_contact_pictures,
)
from ._cross_section import cross_section as cross_section
from ._data import ReportData as ReportData, analyse as analyse
from ._force_deflection_chart import force_deflection_chart as force_deflection_chart
from ._force_orbit import force_orbit as force_orbit
from ._frequency_chart import frequency_chart as frequency_chart
from ._frequency_loci_chart import frequency_loci_chart as frequency_loci_chart
from ._history_chart import history_chart as history_chart
from ._life_chart import life_chart as life_chart
from ._line_contact_chart import line_contact_chart as line_contact_chart
from ._loss_chart import loss_chart as loss_chart
from ._mode_animation import (
    save_mode_animation as save_mode_animation,
    save_mode_animations as save_mode_animations,
)
from ._mode_shapes import mode_shapes as mode_shapes
from ._optimisation import (
    Change as Change,
    Limit as Limit,
    Optimisation as Optimisation,
    summarise_optimisation as summarise_optimisation,
)
from ._optimisation_chart import optimisation_chart as optimisation_chart
from ._power_flow import (
    PowerFlow as PowerFlow,
    energy_flow as energy_flow,
    power_history as power_history,
    steady_flow as steady_flow,
)
from ._power_flow_chart import (
    power_flow_chart as power_flow_chart,
    power_history_chart as power_history_chart,
)
from ._pressure_map import (
    pressure_map as pressure_map,
    pressure_profiles as pressure_profiles,
)
from ._published_figure import published_figure as published_figure
from ._published_pressure import published_pressure as published_pressure
from ._response_chart import response_chart as response_chart
from ._sensitivity_bars import sensitivity_bars as sensitivity_bars
from ._shaft_limits_chart import shaft_limits_chart as shaft_limits_chart
from ._stage_animation import save_motion_animation as save_motion_animation
from ._stress_section import stress_section as stress_section
from ._style import save_figure as save_figure
from ._subsurface_chart import subsurface_chart as subsurface_chart
from ._sweep_map import sweep_map as sweep_map
from ._thread_load_chart import thread_load_chart as thread_load_chart
from ._transient_chart import settling_time as settling_time, transient_chart as transient_chart
from ._transient_pictures import save_transient_pictures as save_transient_pictures
from ._write import write_report as write_report
