"""Tables of a file that have their own rules."""

from ._optimise_table import OptimiseTable as OptimiseTable, design_problem as design_problem
from ._scenario_table import scenario_of as scenario_of
from ._table import (
    Table as Table,
    checked as checked,
    problem as problem,
    read_boolean as read_boolean,
    read_choice as read_choice,
    read_tables as read_tables,
    read_text as read_text,
)
