"""Searches from one start, and the functions that they evaluate."""

from ._evaluator import (
    Evaluator as Evaluator,
    Guarded as Guarded,
    Point as Point,
)
from ._margin_rows import MarginRow as MarginRow
from ._methods import BOUNDS_ONLY as BOUNDS_ONLY, find_search as find_search
from ._search import Search as Search
