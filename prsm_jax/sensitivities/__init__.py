"""How quantities respond to parameters: exact derivatives, in SI units and relative."""

from ._sensitivity import (
    DEFAULT_PARAMETERS as DEFAULT_PARAMETERS,
    DEFAULT_QUANTITIES as DEFAULT_QUANTITIES,
    sensitivity as sensitivity,
)
from ._table import Sensitivity as Sensitivity
