"""Charts of motion: histories, forces, losses, power flow."""

from ._efficiency import efficiency_text as efficiency_text, share_text as share_text
from ._force_orbit import force_orbit as force_orbit
from ._history_chart import (
    History as History,
    histories as histories,
    history_chart as history_chart,
    integrated as integrated,
    is_constant as is_constant,
    travel_of as travel_of,
)
from ._loss_chart import loss_chart as loss_chart
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
from ._transient_chart import (
    settles as settles,
    settling_words as settling_words,
    time_to_settle as time_to_settle,
    transient_chart as transient_chart,
)
