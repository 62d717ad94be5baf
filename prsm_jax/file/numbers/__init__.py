"""Numbers with units, and messages that name them."""

from ._csv import (
    CsvColumn as CsvColumn,
    csv_column as csv_column,
    csv_heading as csv_heading,
    csv_number as csv_number,
    csv_rows as csv_rows,
)
from ._layout import (
    TableChoice as TableChoice,
    table_choices as table_choices,
    tag_of as tag_of,
    takes_numbers as takes_numbers,
    usual_law as usual_law,
)
from ._messages import (
    Misplaced as Misplaced,
    Place as Place,
    file_error as file_error,
    one_line as one_line,
    table_name as table_name,
    utf8_text as utf8_text,
)
from ._numbers import (
    bare_number as bare_number,
    is_plain_number as is_plain_number,
    read_integer as read_integer,
    read_number as read_number,
    read_numbers as read_numbers,
    read_quantity as read_quantity,
    refuse_shares as refuse_shares,
    round_in_unit as round_in_unit,
    write_number as write_number,
)
