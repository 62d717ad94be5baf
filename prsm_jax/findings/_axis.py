"""Margins of the axis: is its position loop slower than its mechanics?"""

from collections.abc import Iterator

import jax.numpy as jnp

from ..fields import Scalar
from ..mechanism import Mechanism
from ..quantities import Analysis, evaluate
from ._margin import Margin, Reading, margin_source

#: A position loop that is slower than the first anti-resonance by this factor moves the load as
#: if the axis were rigid; a usual distance in tuning.
_APART = 3.0
_FREQUENCIES = ("antiresonance_frequency", "position_loop_frequency")


@margin_source
def _position_loop(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """The position loop of the motor against the first anti-resonance of the axis."""
    axis = mechanism.axis
    if axis is None or axis.motor is None or axis.motor.controller is None:
        return

    def value(analysis: Analysis) -> Scalar:
        held, loop = evaluate(analysis, _FREQUENCIES).values()
        return held / loop

    def details(analysis: Analysis) -> dict[str, Scalar]:
        values = evaluate(analysis, _FREQUENCIES)
        return {name: jnp.asarray(one) for name, one in values.items()}

    def message(r: Reading) -> str:
        held, loop = (r.details[name] for name in _FREQUENCIES)
        effect = (
            "the controller holds the motor while the load vibrates"
            if r.severity == "warning"
            else "the motion of the load differs from that of the motor"
        )
        return (
            f"the first anti-resonance of the axis, {held:.4g} Hz with the motor held, is "
            f"{r.value:.2f} times the frequency of the position loop, {loop:.4g} Hz, but should be "
            f"{_APART:g} times: {effect}; lower the proportional_gain of axis.motor.controller, or "
            "stiffen the axis (prsm modal --spatial lists the strain energy of each spring)"
        )

    yield Margin(
        "position_loop",
        index + 1,
        value,
        (("warning", 1.0), ("note", _APART)),
        message,
        details=details,
        shares=("operating_point",),
    )
