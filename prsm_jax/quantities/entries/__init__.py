"""The quantities of the catalogue, by what they are about."""

from . import (
    _axial_stiffness as _axial_stiffness,
    _axis as _axis,
    _contact as _contact,
    _dimensions as _dimensions,
    _load_sharing as _load_sharing,
    _locking as _locking,
    _operation as _operation,
    _play as _play,
    _rating_life as _rating_life,
    _strength as _strength,
    _truncation as _truncation,
    _vibration as _vibration,
)
from ._contact import stage_pressures as stage_pressures
from ._load_sharing import shared_stage_pressures as shared_stage_pressures
from ._play import stage_preloaded_pressure as stage_preloaded_pressure
from ._rating_life import (
    minimum_amplitude_of as minimum_amplitude_of,
    rating_life_of as rating_life_of,
)
from ._strength import (
    dynamic_capacity_of as dynamic_capacity_of,
    on_one_flank as on_one_flank,
    sharing_factor_of as sharing_factor_of,
    static_capacity_of as static_capacity_of,
    truncated_fatigue_of as truncated_fatigue_of,
)
