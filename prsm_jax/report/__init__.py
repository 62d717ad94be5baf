"""Pictures and reports for engineers: millimetres, rpm, kilonewtons, megapascals, degrees."""

from . import _charts_of_results as _charts_of_results  # the charts that `plot` draws
from ._style import save_figure as save_figure, save_figures as save_figures
from .animations import (
    mode_shapes as mode_shapes,
    save_mode_animation as save_mode_animation,
    save_mode_animations as save_mode_animations,
    save_motion_animation as save_motion_animation,
)
from .contact_charts import (
    contact_ellipses as contact_ellipses,
    force_deflection_chart as force_deflection_chart,
    line_contact_chart as line_contact_chart,
    pressure_map as pressure_map,
    pressure_profiles as pressure_profiles,
    published_pressure as published_pressure,
    roller_force_chart as roller_force_chart,
    stress_section as stress_section,
    subsurface_chart as subsurface_chart,
    thread_load_chart as thread_load_chart,
)
from .design_charts import (
    Change as Change,
    Limit as Limit,
    Optimisation as Optimisation,
    calibration_chart as calibration_chart,
    catalogue_chart as catalogue_chart,
    contribution_bars as contribution_bars,
    cost_chart as cost_chart,
    front_chart as front_chart,
    life_chart as life_chart,
    optimisation_chart as optimisation_chart,
    parallel_chart as parallel_chart,
    published_figure as published_figure,
    sensitivity_bars as sensitivity_bars,
    shaft_limits_chart as shaft_limits_chart,
    summarise_optimisation as summarise_optimisation,
    tolerance_histograms as tolerance_histograms,
    tolerance_scatter as tolerance_scatter,
    tornado_chart as tornado_chart,
    yield_chart as yield_chart,
)
from .document import (
    LIMITS as LIMITS,
    MARGINS_IN_WORDS as MARGINS_IN_WORDS,
    Picture as Picture,
    Section as Section,
    Table as Table,
    checks_table as checks_table,
    contact_pictures as contact_pictures,
    limit_cells as limit_cells,
    limits_in_words as limits_in_words,
    limits_table as limits_table,
    point_words as point_words,
    report_section as report_section,
    save_contact_pictures as save_contact_pictures,
    save_transient_pictures as save_transient_pictures,
    study_sections as study_sections,
    write_document as write_document,
    write_report as write_report,
    write_study as write_study,
)
from .drawings import cross_section as cross_section, section_svg as section_svg
from .motion_charts import (
    PowerFlow as PowerFlow,
    energy_flow as energy_flow,
    force_orbit as force_orbit,
    history_chart as history_chart,
    loss_chart as loss_chart,
    power_flow_chart as power_flow_chart,
    power_history as power_history,
    power_history_chart as power_history_chart,
    steady_flow as steady_flow,
    time_to_settle as time_to_settle,
    transient_chart as transient_chart,
)
from .results import (
    Origin as Origin,
    ReportData as ReportData,
    analyse as analyse,
    origin_of_file as origin_of_file,
    with_optimisation as with_optimisation,
)
from .study_charts import (
    conflict_maps as conflict_maps,
    front_gradient_chart as front_gradient_chart,
    study_maps as study_maps,
    variant_changes as variant_changes,
    variant_fronts as variant_fronts,
)
from .sweep_charts import sweep_figure as sweep_figure, sweep_map as sweep_map
from .vibration_charts import (
    NUT_POSITION_QUANTITIES as NUT_POSITION_QUANTITIES,
    axis_compliance_chart as axis_compliance_chart,
    axis_mode_shapes as axis_mode_shapes,
    campbell_chart as campbell_chart,
    frequency_chart as frequency_chart,
    frequency_loci_chart as frequency_loci_chart,
    nut_position_chart as nut_position_chart,
    response_chart as response_chart,
    save_axis_pictures as save_axis_pictures,
)
