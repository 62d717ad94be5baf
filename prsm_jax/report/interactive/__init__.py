"""Interactive charts of the page: curves with units, and the library that draws them."""

from ._bars import (
    elasticity_bars as elasticity_bars,
    frequency_bars as frequency_bars,
    objective_curve as objective_curve,
)
from ._chart import Axis as Axis, Chart as Chart, Curve as Curve
from ._motion import (
    history_curves as history_curves,
    loss_bars as loss_bars,
    power_curves as power_curves,
    transient_curves as transient_curves,
)
from ._plotly import (
    plotly_figure as plotly_figure,
    plotly_library as plotly_library,
    script_text as script_text,
)
from ._strength import (
    deflection_curves as deflection_curves,
    life_curve as life_curve,
    shaft_limit_curves as shaft_limit_curves,
    thread_load_bars as thread_load_bars,
)
