"""Stored errors and ratios of the quick benchmarks, and the comparison with them."""

from .compared import (
    Failure as Failure,
    Numbers as Numbers,
    compare as compare,
    conservative as conservative,
    recurring as recurring,
)
from .of_case import numbers_of_case as numbers_of_case
from .stored import STORED as STORED, read_stored as read_stored, store as store
from .verdict import guarded as guarded
