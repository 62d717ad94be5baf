"""Relations between numbers; a violation names the place in the file of the number to change."""

from ..fields import Contradiction, check_stage
from ..mechanism import Mechanism
from .numbers import Misplaced


def check_dimensions(mechanism: Mechanism) -> None:
    """Refuse dimensions that contradict each other.

    **Raises:** `Misplaced` at the first key that does not fit the others.
    """
    for index, stage in enumerate(mechanism.stages):
        try:
            check_stage(stage)
        except Contradiction as error:
            raise Misplaced(("stage", index, *error.place), error.message) from None
