"""Optional parts that a mechanism has, those that it leaves out, and the cost of each."""

from ._account import PROGRAMS as PROGRAMS, Account as Account
from ._explain import explain as explain
from ._explanation import (
    Cost as Cost,
    Explanation as Explanation,
    Part as Part,
    Program as Program,
)
from ._places import Place as Place, places as places, without as without
