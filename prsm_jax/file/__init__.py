"""Mechanisms from TOML files with units, and back. Only this room knows the format of files."""

from ._comments import commented as commented, rounded as rounded
from ._edit import edit as edit, source_bytes as source_bytes, source_text as source_text
from ._examples import (
    example_names as example_names,
    example_summary as example_summary,
    example_text as example_text,
)
from ._read import load as load, loads as loads
from ._settings import apply_settings as apply_settings
from ._write import dump as dump, dumps as dumps
from .numbers import (
    TableChoice as TableChoice,
    read_quantity as read_quantity,
    round_in_unit as round_in_unit,
    table_choices as table_choices,
)
