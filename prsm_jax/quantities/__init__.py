"""The catalogue of quantities that sensitivities, optimisation, sweeps and reports share.

A quantity of your own is one function of an `Analysis` under the `quantity` decorator.
"""

from ._analysis import Analysis as Analysis, SharedLoad as SharedLoad
from ._assumptions import (
    assumption as assumption,
    derives_dynamic_capacity as derives_dynamic_capacity,
    derives_static_capacity as derives_static_capacity,
    has_contacts as has_contacts,
)
from ._axis_modes import AXIS_QUANTITIES as AXIS_QUANTITIES
from ._by_friction import by_friction as by_friction
from ._catalogue import (
    Quantity as Quantity,
    QuantityLike as QuantityLike,
    assumptions as assumptions,
    catalogue as catalogue,
    component_names as component_names,
    find_quantity as find_quantity,
    is_function as is_function,
    named_quantities as named_quantities,
    quantity as quantity,
    quantity_name as quantity_name,
    quantity_names as quantity_names,
    quantity_of as quantity_of,
)
from ._compute import (
    available_quantities as available_quantities,
    compute as compute,
    compute_checked as compute_checked,
    compute_coded as compute_coded,
    evaluate as evaluate,
    evaluate_checked as evaluate_checked,
    evaluate_coded as evaluate_coded,
)
from ._reasons import REASONS as REASONS
from .entries import (
    dynamic_capacity_of as dynamic_capacity_of,
    minimum_amplitude_of as minimum_amplitude_of,
    on_one_flank as on_one_flank,
    rating_life_of as rating_life_of,
    shared_stage_pressures as shared_stage_pressures,
    sharing_factor_of as sharing_factor_of,
    stage_preloaded_pressure as stage_preloaded_pressure,
    stage_pressures as stage_pressures,
    static_capacity_of as static_capacity_of,
    truncated_fatigue_of as truncated_fatigue_of,
)
