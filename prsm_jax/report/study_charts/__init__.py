"""Pictures of a study: maps, conflicts, front with gradients, influence of parts of the physics."""

from ._conflict_maps import conflict_maps as conflict_maps
from ._front_gradients import front_gradient_chart as front_gradient_chart
from ._maps import study_maps as study_maps
from ._variants import variant_changes as variant_changes, variant_fronts as variant_fronts
