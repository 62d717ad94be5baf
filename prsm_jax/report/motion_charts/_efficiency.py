"""Efficiency as text: a percentage, or the name of a state without efficiency."""

from typing import SupportsFloat

from ...dynamics import SteadyState
from ...text import fixed, with_label

_SELF_LOCKING = "self-locking"
#: States by `SteadyState.result_name` whose words differ from their name.
_STATES = {"self_locking": _SELF_LOCKING}


def efficiency_text(state: SteadyState) -> str:
    """The efficiency of a steady state in per cent, or the name of the state if it has none.

    For a thread that locks or jams, the number in `efficiency` has no meaning.
    """
    if not state.has_efficiency:
        name: str = state.result_name
        return _STATES.get(name, name.replace("_", " "))
    # Of a steady state below 0 that names no reason.
    return _SELF_LOCKING if float(state.efficiency) < 0 else share_text(state.efficiency)


def share_text(efficiency: SupportsFloat) -> str:
    """An efficiency of a moving mechanism in per cent; there is none where no power leaves it."""
    value = float(efficiency)
    if value != value:
        return "not defined"
    return with_label(fixed(100 * value, 2), "%", " ") if value > 0 else "none"
