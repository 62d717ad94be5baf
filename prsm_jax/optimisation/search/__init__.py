"""Searches from one start, and the functions that they evaluate."""

from ._constrained import (
    Slsqp as Slsqp,
    TrustConstr as TrustConstr,
)
from ._evaluator import Evaluator as Evaluator, Point as Point
from ._functions import SearchFunctions as SearchFunctions
from ._lbfgs import Lbfgs as Lbfgs
from ._margin_rows import MarginRow as MarginRow, respected as respected
from ._method import SearchMethod as SearchMethod, SearchResult as SearchResult
from ._methods import search_of as search_of
from ._multi_start import MultiStart as MultiStart
from ._optax import Adam as Adam, Optax as Optax
from ._scipy import Scipy as Scipy
from ._worst import WorstCaseFunctions as WorstCaseFunctions
