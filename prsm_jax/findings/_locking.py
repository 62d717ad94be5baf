"""Margins of friction: does it let the screw move the load, and the load the screw?"""

from collections.abc import Iterator

import equinox as eqx
import jax.numpy as jnp

from ..contact import load_of
from ..dynamics import (
    friction_needs_load,
    jamming_coefficient,
    jamming_margin,
    locking_coefficient,
    steady_state,
)
from ..mechanism import Mechanism, Scalar
from ..quantities import Analysis
from ._margin import Margin, Reading, margin_source

#: Friction coefficients scatter by this much with lubricant and wear.
_SCATTER = 0.3
#: Backward efficiency below which that scatter may decide whether the load moves.
_NEARLY_HELD = 0.15


def _without_friction(mechanism: Mechanism) -> bool:
    return all(stage.friction is None for stage in mechanism.stages)


@margin_source
def _jamming(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """A driving screw cannot move its load, or nearly cannot."""
    if _without_friction(mechanism):
        return

    def value(analysis: Analysis) -> Scalar:
        stage = analysis.mechanism.stages[index]
        alone = eqx.tree_at(lambda m: m.stages, analysis.mechanism, (stage,))
        geometry = analysis.kinematics[index]
        load = analysis.load if friction_needs_load(alone) else None
        return jamming_margin(alone, (geometry,), jnp.abs(analysis.speed), load)

    def message(r: Reading) -> str:
        what = "is past" if r.severity == "error" else "comes near"
        limit = r.details["limit"]
        return (
            f"the friction coefficient of the threads, {(1 - r.value) * limit:.3g}, {what} that at "
            f"which the driving screw jams, {limit:.3g}: lower it, or raise the contact angle"
        )

    yield Margin(
        "jamming",
        index + 1,
        value,
        (("error", 0.0), ("warning", _SCATTER)),
        message,
        details=lambda analysis: {"limit": jamming_coefficient(analysis.kinematics[index])},
        shown=lambda r: ((1 - r.value) * r.details["limit"], r.details["limit"]),
        reserve=1e-2,
        strict=True,
    )


@margin_source
def _self_locking(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """The load cannot turn the screw, or only lubricant and wear decide whether it does."""
    if _without_friction(mechanism) or index > 0:
        return

    def value(analysis: Analysis) -> Scalar:
        speed = -jnp.abs(analysis.speed)
        load = jnp.abs(load_of(analysis.mechanism, analysis.signed_load))
        return steady_state(analysis.mechanism, speed, load, analysis.kinematics).efficiency

    def message(r: Reading) -> str:
        limit = r.details["limit"]
        if r.severity == "note":
            return (
                "self-locking: friction holds the load without torque, and the screw has to be "
                f"driven back (threads alone hold above a friction coefficient of {limit:.3g})"
            )
        return (
            f"friction nearly holds the load, which gives only {r.value:.0%} of its work to the "
            "screw: whether it turns it depends on lubricant and wear (threads alone hold above a "
            f"friction coefficient of {limit:.3g}); change friction or contact angle, or add a "
            "brake"
        )

    yield Margin(
        "self_locking",
        1,
        value,
        (("note", 0.0), ("warning", _NEARLY_HELD)),
        message,
        details=lambda analysis: {"limit": locking_coefficient(analysis.kinematics[0])},
        shown=lambda r: (r.value, 0.0),
    )
