"""The result of a study: it prints itself, and becomes JSON."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..results import Shown
from ..text import TextTable
from ._conflict import plain
from ._parts import StudyParts
from ._printing import sentences_of, text_of
from ._tables import tables_of


@dataclass(frozen=True, repr=False)
class DriverStudy(Shown, StudyParts):
    """Effect of drivers on quantities, conflicts of quantities, and the best compromises.

    - `title`: of the mechanism.
    - `problem`: drivers, quantities, objectives and limits.
    - `map`: quantities and elasticities over the grid of the drivers.
    - `conflicts`: of each pair of quantities, and of each quantity with each limit.
    - `front`: the designs that no other design dominates.
    - `designs`: quantities and elasticities of the present design and then of the front's points.
    - `gradients`: the gradient at each point of the front, in numbers and in words.
    - `variants`: the results without parts of the physics.
    - `assumptions`: on which its numbers are based, as sentences.
    """

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers for JSON; `None` where one is not finite."""
        front = self.front.to_dict()
        pairs = zip(front["points"], self.gradients, strict=True)
        front["points"] = [point | gradient.to_dict() for point, gradient in pairs]
        return {
            "map": self._map(),
            "conflict": [one.to_dict() for one in self.conflicts],
            "front": front,
            "variants": [one.to_dict() for one in self.variants],
            "assumptions": list(self.assumptions),
        }

    def _map(self) -> dict[str, Any]:
        problem, grid = self.problem, self.map
        present = self.present_elasticities
        quantities = {}
        for name in problem.names:
            values = grid.values[name][grid.usable]
            quantities[name] = {
                "unit": problem.units[name],
                "sense": problem.sense(name),
                "limit": name in problem.limited,
                "smallest": plain(float(values.min())) if values.size else None,
                "largest": plain(float(values.max())) if values.size else None,
                "present": plain(float(self.designs.values[name][0])),
                "elasticities_present": {by: plain(v) for by, v in present[name].items()},
            }
        return {
            "drivers": {
                one.name: {
                    "unit": one.unit,
                    "lower": one.lower,
                    "upper": one.upper,
                    "present": one.present,
                    "values": grid.coordinates[one.name].tolist(),
                }
                for one in problem.drivers
            },
            "quantities": quantities,
            "points": int(grid.usable.size),
            "failed": int(np.sum(~grid.usable)),
            "reasons": dict(grid.reasons),
            "errors": int(np.sum(grid.error & grid.usable)),
            "allowed": int(np.sum(grid.allowed)),
        }

    def tables(self) -> dict[str, tuple[TextTable, ...]]:
        """Tables in an engineer's units, by part: `drivers`, `conflict`, `front`, `variants`."""
        return tables_of(self)

    def sentences(self) -> dict[str, list[str]]:
        """The main results in words, by the same parts."""
        return sentences_of(self)

    def text(self, width: int | None = None) -> str:
        """Tables in an engineer's units, and sentences.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the tables need.
        """
        return text_of(self, width)

    def __str__(self) -> str:
        return self.text(120)
