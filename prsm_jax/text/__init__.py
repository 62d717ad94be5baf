"""Numbers in an engineer's units, plain text, and tables of text."""

from ._csv_text import comma_in_number as comma_in_number, csv_cells as csv_cells
from ._display_units import (
    MINUS as MINUS,
    UNIT_LABELS as UNIT_LABELS,
    DisplayUnit as DisplayUnit,
    NumberText as NumberText,
    digits_for as digits_for,
    display_unit as display_unit,
    fixed as fixed,
    in_unit as in_unit,
    is_efficiency as is_efficiency,
    number as number,
    related as related,
    show as show,
    state_without_efficiency as state_without_efficiency,
    trimmed as trimmed,
    with_label as with_label,
)
from ._lines import Line as Line, aligned as aligned, html_table as html_table
from ._plain_text import (
    markdown as markdown,
    printable as printable,
    short_heading as short_heading,
    short_label as short_label,
)
from ._text_table import NOT_DEFINED as NOT_DEFINED, TextTable as TextTable
