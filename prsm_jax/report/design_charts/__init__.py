"""Charts of a design: life, limits, sensitivities, tolerances, changes by an optimiser."""

from ._calibration_chart import calibration_chart as calibration_chart
from ._catalogue_chart import catalogue_chart as catalogue_chart
from ._front_chart import front_chart as front_chart
from ._life_chart import life_chart as life_chart, lives_under as lives_under
from ._optimisation import (
    Change as Change,
    Limit as Limit,
    Optimisation as Optimisation,
    relative_change as relative_change,
    signed_change as signed_change,
    summarise_optimisation as summarise_optimisation,
)
from ._optimisation_chart import optimisation_chart as optimisation_chart
from ._parallel_chart import parallel_chart as parallel_chart
from ._published_figure import published_figure as published_figure
from ._sensitivity_bars import sensitivity_bars as sensitivity_bars
from ._shaft_limits_chart import (
    shaft_limits as shaft_limits,
    shaft_limits_chart as shaft_limits_chart,
)
from ._tolerance_charts import (
    contribution_bars as contribution_bars,
    tolerance_histograms as tolerance_histograms,
    tolerance_scatter as tolerance_scatter,
)
from ._tornado_chart import tornado_chart as tornado_chart
from ._yield_charts import cost_chart as cost_chart, yield_chart as yield_chart
