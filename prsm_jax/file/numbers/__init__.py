"""Numbers with units, and messages that name them."""

from ._layout import (
    TableChoice as TableChoice,
    is_law_field as is_law_field,
    module_classes as module_classes,
    row_class as row_class,
    table_choices as table_choices,
    unit_of as unit_of,
    usual_law as usual_law,
)
from ._messages import (
    Misplaced as Misplaced,
    Place as Place,
    file_error as file_error,
    one_line as one_line,
    table_name as table_name,
)
from ._numbers import (
    bare_number as bare_number,
    is_plain_number as is_plain_number,
    read_integer as read_integer,
    read_number as read_number,
    read_numbers as read_numbers,
    round_in_unit as round_in_unit,
    write_number as write_number,
)
