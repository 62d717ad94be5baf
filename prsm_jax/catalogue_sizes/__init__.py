"""Mechanisms of the sizes in a maker's catalogue, from the few dimensions that it prints."""

from ._rows import catalogue_rows as catalogue_rows
from ._rules import catalogue_mechanism as catalogue_mechanism
