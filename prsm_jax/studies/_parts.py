"""The results of a study in numbers."""

from dataclasses import dataclass

from ..optimisation import ParetoFront
from ._conflict import Conflict
from ._gradients import FrontGradient, gradients_at
from ._map import DriverMap
from ._problem import StudyProblem
from ._variants import Variant


@dataclass(frozen=True)
class StudyParts:
    """The numbers of a study; see `DriverStudy`."""

    title: str
    problem: StudyProblem
    map: DriverMap
    conflicts: tuple[Conflict, ...]
    front: ParetoFront
    designs: DriverMap
    gradients: tuple[FrontGradient, ...]
    variants: tuple[Variant, ...]
    assumptions: tuple[str, ...]

    @property
    def present_elasticities(self) -> dict[str, dict[str, float]]:
        """Per cent of a quantity per per cent of a driver in the present design."""
        return gradients_at(self.problem, self.designs, 0)

    def conflict(self, first: str, second: str) -> Conflict:
        """The conflict of a pair, in any order. **Raises:** `KeyError` if there is none."""
        for one in self.conflicts:
            if {one.first, one.second} == {first, second}:
                return one
        raise KeyError((first, second))
