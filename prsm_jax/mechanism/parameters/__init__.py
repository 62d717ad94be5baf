"""Numbers of a mechanism by name: read and set, one or several."""

from ._check_tolerance import check_tolerance as check_tolerance
from ._directions import (
    Directions as Directions,
    directions_of as directions_of,
    move_alone as move_alone,
    move_while_others_stay as move_while_others_stay,
)
from ._follows import (
    dependents_in_words as dependents_in_words,
    follows_in_words as follows_in_words,
    what_follows as what_follows,
)
from ._parameters import (
    DESIGN_VARIABLES as DESIGN_VARIABLES,
    Parameter as Parameter,
    all_parameters as all_parameters,
    check_parameter as check_parameter,
    find_parameters as find_parameters,
    get_parameter as get_parameter,
    set_parameter as set_parameter,
)
from ._set_parameters import (
    check_independent as check_independent,
    set_parameters as set_parameters,
    written_out as written_out,
)
from ._tolerance_zones import (
    tolerance_zones as tolerance_zones,
)
from ._traced_counts import (
    stages_of_count as stages_of_count,
    with_traced_counts as with_traced_counts,
)
