"""Tables of a file: of any part of a mechanism, and those that have their own rules."""

from ._optimise_table import design_problem as design_problem, read_optimise as read_optimise
from ._part_table import NUMBER as NUMBER, meaning as meaning, read_module as read_module
from ._table import (
    Key as Key,
    plain as plain,
    read_keys as read_keys,
    read_rows as read_rows,
    read_text as read_text,
)
from ._tolerance_table import (
    read_tolerances as read_tolerances,
    tolerances_of as tolerances_of,
)
