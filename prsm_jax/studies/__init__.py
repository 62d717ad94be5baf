"""Studies of a few drivers: their effect on quantities, conflicts of these, and the front."""

from ._conflict import Conflict as Conflict, cosine as cosine
from ._gradients import FrontGradient as FrontGradient
from ._map import DriverMap as DriverMap
from ._problem import Driver as Driver, StudyProblem as StudyProblem
from ._result import DriverStudy as DriverStudy
from ._study import study as study
from ._variants import Variant as Variant
