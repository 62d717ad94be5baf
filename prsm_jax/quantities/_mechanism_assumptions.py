"""Assumptions that concern a mechanism as a whole, not one of its stages."""

from collections.abc import Callable

from ..mechanism import Mechanism


def _stages_alone(mechanism: Mechanism) -> str | None:
    """For the natural frequencies of stages, and what follows from them."""
    axis = mechanism.axis
    if axis is None or (axis.motor is None and axis.shaft is None and axis.load is None):
        return None
    return (
        "The modes of the stages leave out [axis]: motor, coupling, elastic screw, its bearings "
        "and the load are not in them, and no body moves along the axis, so the lowest resonances "
        "of the drive are missing, and with them their critical speeds. prsm modal FILE --spatial "
        "has all of them."
    )


#: Sentences by name; `None` where one does not apply.
OF_MECHANISM: dict[str, Callable[[Mechanism], str | None]] = {"stages_alone": _stages_alone}
