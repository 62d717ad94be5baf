"""RODASP: its steps, and derivatives that follow the variational equation along them.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from ._along_steps import Motion as Motion, Solution as Solution, at_samples as at_samples
from ._solver import Rodasp as Rodasp
from ._windows import (
    Integrated as Integrated,
    Problem as Problem,
    integrated as integrated,
    supports_windows as supports_windows,
)
