"""Mechanisms of the sizes in a maker's catalogue, from the few dimensions that it prints."""

from ._mechanisms import (
    catalogue_mechanism as catalogue_mechanism,
    plain_catalogue_mechanism as plain_catalogue_mechanism,
)
from ._rows import DIMENSIONS as DIMENSIONS, catalogue_rows as catalogue_rows
from ._size_rules import FITTED as FITTED, SizeRules as SizeRules
