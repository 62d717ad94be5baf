"""Findings on friction: does it let the screw move the load, and the load the screw?"""

import functools
from collections.abc import Iterator

import equinox as eqx
import jax.numpy as jnp

from .._errors import MissingDataError
from ..contact import load_of
from ..dynamics import (
    all_kinematics,
    jamming_coefficient,
    jamming_margin,
    locking_coefficient,
    steady_state,
)
from ..geometry import Finding
from ..mechanism import Mechanism

#: Friction coefficients scatter by this much with lubricant and wear.
_SCATTER = 0.3
#: Backward efficiency below which that scatter may decide whether the load moves.
_NEARLY_HELD = 0.15


def _speed(mechanism: Mechanism):
    point = mechanism.operating_point
    dtype = mechanism.stages[0].thread.lead.dtype
    return jnp.ones((), dtype) if point is None else jnp.abs(point.speed)


@functools.cache
def _numbers():
    @eqx.filter_jit
    def numbers(mechanism: Mechanism):
        kinematics, speed = all_kinematics(mechanism), _speed(mechanism)
        jamming = [
            (
                jamming_margin(_alone(mechanism, index), (geometry,), speed),
                jamming_coefficient(geometry),
                locking_coefficient(geometry),
            )
            for index, geometry in enumerate(kinematics)
        ]
        load = jnp.abs(load_of(mechanism, None))
        return jamming, steady_state(mechanism, -speed, load, kinematics).efficiency

    return numbers


def _alone(mechanism: Mechanism, index: int) -> Mechanism:
    return eqx.tree_at(lambda m: m.stages, mechanism, (mechanism.stages[index],))


def _found(mechanism: Mechanism) -> Iterator[Finding]:
    jamming, backward = _numbers()(mechanism)
    for number, (margin, jams, _) in enumerate(jamming, start=1):
        share, limit = float(margin), float(jams)
        if not share < _SCATTER:
            continue
        now = (1 - share) * limit
        stuck = share <= 0
        what = "is past" if stuck else "comes near"
        yield Finding(
            "jamming",
            "error" if stuck else "warning",
            number,
            now,
            limit,
            f"the friction coefficient of the threads, {now:.3g}, {what} that at which the "
            f"driving screw jams, {limit:.3g}: lower it, or raise the contact angle",
        )
    share, limit = float(backward), float(jamming[0][2])
    if not share < _NEARLY_HELD:
        return
    holds = share <= 0
    yield Finding(
        "self_locking",
        "note" if holds else "warning",
        1,
        share,
        0.0,
        "self-locking: friction holds the load without torque, and the screw has to be driven "
        f"back (threads alone hold above a friction coefficient of {limit:.3g})"
        if holds
        else f"friction nearly holds the load, which gives only {share:.0%} of its work to the "
        "screw: whether it turns it depends on lubricant and wear (threads alone hold above a "
        f"friction coefficient of {limit:.3g}); change friction or contact angle, or add a brake",
    )


def locking_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Friction that stops the mechanism, or nearly does.

    `jamming`: a driving screw cannot move its load. `self_locking`: the load cannot turn the screw,
    or nobody knows. Needs an operating point; without it, or without data for a modelled loss,
    nothing is found.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    if all(stage.friction is None for stage in mechanism.stages):
        return ()
    try:
        return tuple(_found(mechanism))
    except MissingDataError:
        return ()
