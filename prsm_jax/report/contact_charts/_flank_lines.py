"""Ends of the flanks beside a contact ellipse: crests and roots, as lines in its plane."""

import math
from dataclasses import dataclass

from jaxtyping import Array

from ...fields import Scalar
from ...geometry import Meshing, flanks_end
from ...mechanism import Stage
from ...programs import one_program_where_possible
from ...strength import EndReach, end_reaches


@dataclass(frozen=True)
class FlankLine:
    """One end of the flanks of a contact, as a straight line in the tangent plane.

    - `side`: `"screw"` or `"nut"`.
    - `words`: what it is, such as "crest of the roller".
    - `distance`: from the contact point, negative where that lies beyond the end [m].
    - `half_extent`: of the ellipse at right angles to the line, under the load that is drawn [m].
    - `outward`: whether it lies on the side away from the roller's axis.
    """

    side: str
    words: str
    distance: float
    half_extent: float
    outward: bool

    def direction(self, semi_major: float, semi_minor: float) -> tuple[float, float]:
        """Unit vector from the contact point to the line, along major and minor axis.

        The half-extent h of an ellipse in a direction at the angle φ to its major axis is
        h² = a² cos² φ + b² sin² φ; the sign of φ is open, as that of the minor axis is.
        """
        span = semi_major**2 - semi_minor**2
        square = (self.half_extent**2 - semi_minor**2) / span if span > 0 else 1.0
        square = min(max(square, 0.0), 1.0)
        sign = 1.0 if self.outward else -1.0
        return sign * math.sqrt(square), sign * math.sqrt(1 - square)


@one_program_where_possible
def _reaches(stage: Stage, load: Scalar, meshing: Meshing | None) -> list[tuple[EndReach, Array]]:
    return [(one, one.half_extent(load)) for one in end_reaches(stage, meshing)]


def flank_lines(
    stage: Stage, load: Scalar, meshing: Meshing | None = None
) -> tuple[FlankLine, ...]:
    """Ends of the flanks of a stage, for `contact_ellipses`; none if no flank has an end.

    **Arguments:**

    - `stage`: the stage; needs materials and `engaged_threads` if flanks end.
    - `load`: axial load, shared equally by all threads [N].
    - `meshing`: its meshing, if already known.

    **Raises:** `MissingDataError` where the stage lacks data.
    """
    if not flanks_end(stage):
        return ()
    return tuple(
        FlankLine(
            one.side,
            f"{one.end.kind} of the {one.end.body}",
            float(one.end.distance),
            float(half),
            one.end.way == "from_roller_axis",
        )
        for one, half in _reaches(stage, load, meshing)
    )
